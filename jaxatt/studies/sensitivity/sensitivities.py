"""Sensitivities of the answer of a scenario."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jaxatt.problems.family import PhaseStart, SearchOptions
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.registry import family_of
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.settings import check_precision
from jaxatt.scenarios.catalog import load
from jaxatt.scenarios.loader import replace
from jaxatt.studies.sensitivity.parameters import directions_of
from jaxatt.studies.sensitivity.result import ScenarioSensitivities


def sensitivities(
    scenario: str | Path | Scenario,
    parameters: Sequence[str] | None = None,
    *,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> ScenarioSensitivities:
    """Solve a scenario and differentiate its answer by numbers of the scenario.

    parameters : names as in the file, e.g. "vehicle.wheels.torque_limit_Nm",
        "vehicle.inertia_kgm2.0.0" or "vehicle.wheels.axes.*.2"; all numbers that the answer depends
        on by default.
    starts, seed : in place of the scenario's own.
    report : called with (stage, starts ended).

    Raises `ScenarioError` where a name is no number of the scenario, or where the answers of its
    kind have no sensitivities.
    """
    check_precision()
    case = scenario if isinstance(scenario, Scenario) else load(scenario)
    changes = {"solver.starts": starts, "solver.seed": seed}
    given = {key: value for key, value in changes.items() if value is not None}
    case = replace(case, given) if given else case
    answer = sensitive_answer(case, report)
    found = directions_of(case, answer.arguments, parameters)
    record = answer.optimum.along(found.names, found.values, found.along)
    return ScenarioSensitivities(case, answer.label, answer.unit, record, answer.notes)


def sensitive_answer(scenario: Scenario, report: Report | None = None) -> SensitiveAnswer:
    """Search the only phase of a scenario, and polish its answer."""
    family = family_of(scenario)
    if family.phases(scenario) > 1:
        raise ScenarioError(
            f"{scenario.name}: has {family.phases(scenario)} phases, each of which begins where "
            "the flight of the one before ended; ask for the sensitivities of one phase at a time"
        )
    start, options = PhaseStart(), SearchOptions()
    family.check(scenario, options)
    return family.sensitive(scenario, start, family.search(scenario, start, options, report))
