"""Read a design study from a TOML document."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt import scenarios
from jaxatt.problems.reading.checking import refuse_faults
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table, shown
from jaxatt.problems.reading.names import read_name
from jaxatt.problems.reading.schema import nearest
from jaxatt.problems.registry import family_of
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.loader import plain_values
from jaxatt.studies.attitude_map.targets import map_targets
from jaxatt.studies.design.study import DesignStudy
from jaxatt.studies.sweep.numbers import whole_document
from jaxatt.studies.sweep.reading import read_base, read_study_file
from jaxatt.studies.sweep.study import Varied
from jaxatt.studies.sweep.vary import check_apart, read_varied
from jaxatt.studies.tables import DESIGN_KEYS, LIMIT

_UNLIKE_SWEEPS = ("values", "count", "whole")
_POINTS_EACH = 4


def load_design(name_or_path: str | Path, changes: Mapping[str, Any] | None = None) -> DesignStudy:
    """Return the bundled design study of this name, or the one in a TOML file.

    changes : of the scenario, as in [fixed], on top of those.  Raises `ScenarioError`.
    """
    name = str(name_or_path)
    if scenarios.kind_of(name) == "design":
        origin = f"{name}.toml"
        return read_design(parse(scenarios.text(name), origin), origin, None, changes)
    document = read_study_file(name_or_path, "design")
    return read_design(document, name, Path(name_or_path).parent, changes)


def read_design(
    document: Mapping[str, Any],
    origin: str = "design",
    folder: Path | None = None,
    changes: Mapping[str, Any] | None = None,
) -> DesignStudy:
    """Check a document that has the names of a design study's file.

    folder : where the scenario's file is looked up; the working folder by default.
    """
    plain = plain_values(document)
    refuse_faults(plain, origin, DESIGN_KEYS)
    top = Table(plain, origin, "", DESIGN_KEYS)
    name = read_name(top)
    scenario, fixed = read_base(top, folder, changes)
    measure = _measure(scenario, origin)
    variables = _variables(top, scenario)
    minimised, at_most = _goal(top, variables, measure)
    return DesignStudy(
        name=name,
        title=top.text("title", name),
        origin=origin,
        scenario=scenario,
        whole=whole_document(scenario),
        variables=variables,
        measure=measure,
        minimised=minimised,
        at_most=at_most,
        over=top.choice("over"),
        targets=_targets(top, scenario),
        points=top.integer("points", _POINTS_EACH * len(variables)),
        seed=top.integer("seed"),
        document={**plain, "fixed": fixed},
    )


def _measure(scenario: Scenario, origin: str) -> str:
    """What the answers of a scenario minimise, which a design is judged by."""
    measure = family_of(scenario).measure(scenario)
    if not measure or len(scenario.targets) != 1:
        raise ScenarioError(
            f"{origin}: scenario: {scenario.name} is no turn in free time to one target, whose "
            "answers a design can follow; choose such a scenario, or set objective.kind = "
            '"minimum-time" under [fixed]'
        )
    if scenario.leaves_roll_free:
        raise ScenarioError(
            f"{origin}: scenario: [target] of {scenario.name} leaves the roll free, and a design "
            "is judged by whole attitudes; add constrain beside align"
        )
    return measure


def _variables(top: Table, scenario: Scenario) -> tuple[Varied, ...]:
    entries = top.require("design")
    if not isinstance(entries, list) or not entries:
        top.fail("design", "is no list of tables", "write one [[design]] for every number")
    whole = whole_document(scenario)
    faults, found = Faults(), []
    for k, entry in enumerate(entries):
        for key in _UNLIKE_SWEEPS:
            if isinstance(entry, dict) and key in entry:
                raise ScenarioError(
                    f"{top.origin}: [[design]] no. {k + 1} {key} = {shown(entry[key])}: is for "
                    "sweeps; a design is looked for between two numbers, write from and to"
                )
        found.append(
            faults.of(read_varied, entry, k, top.origin, "design", "descent", scenario, whole)
        )
    faults.refuse()
    check_apart(found, top.origin, "design")
    return tuple(found)


def _goal(
    top: Table, variables: tuple[Varied, ...], measure: str
) -> tuple[int | None, float | None]:
    """Index of the variable that is minimised and the limit of the measure, or neither."""
    names = tuple(variable.name for variable in variables)
    minimise = top.text("minimise", measure)
    if minimise not in (measure, *names):
        near = nearest(minimise, (measure, *names))
        hint = f"did you mean '{near}'? " if near else ""
        allowed = f"{hint}allowed: {', '.join((measure, *names))}"
        top.fail("minimise", "not one of the choices", allowed)
    if minimise == measure:
        if "at_most" in top:
            top.fail(
                "at_most", f"limits {measure}, which is minimised", "drop it, or minimise a number"
            )
        return None, None
    if "at_most" not in top:
        top.fail(
            "minimise",
            "needs a limit, or the least is the end of its range",
            f"add at_most = {{ {measure} = 40.0 }}",
        )
    limits = Table(top.data["at_most"], top.origin, "[at_most]", {measure: LIMIT})
    return names.index(minimise), limits.number(measure)


def _targets(top: Table, scenario: Scenario) -> Floats:
    """Target attitudes (M, 4): the scenario's own, a list, or a number spread over all turns."""
    given = top.data.get("targets")
    if given is None:
        return np.asarray(scenario.targets[0].q_ob)[None]
    if not isinstance(given, list):
        return map_targets(scenario, top.integer("targets")).q_ob
    if not given or not all(isinstance(each, dict) and each for each in given):
        top.fail(
            "targets",
            "is no list of attitudes",
            "write [[targets]] with attitude_deg = [90.0, 45.0, 15.0] for each, or their number",
        )
    found = []
    for each in given:
        changes = {f"target.{key}": value for key, value in each.items()}
        found.append(scenarios.replace(scenario, changes).targets[0].q_ob)
    return np.stack(found)
