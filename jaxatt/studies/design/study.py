"""A design study: numbers of a scenario to be chosen, what is minimised, and for which cases."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.reading.documents import read_file
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.names import read_name
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.scenarios.catalog import load
from jaxatt.scenarios.loader import from_mapping, plain_values, replace
from jaxatt.studies.sweep.numbers import Place, places, set_at, whole_document

MEAN, WORST, NUMBERS = "mean", "worst", "numbers"
_TOP = ("name", "title", "scenario", "minimise", "at_most", "fixed", "vary", "cases")
_VARY = ("field", "from", "to")


@dataclass(frozen=True, eq=False)
class Design:
    """A design study.

    scenario : with what is fixed.  minimise : "mean" or "worst", of the objective over all cases,
    or "numbers", the mean of the numbers as shares of their ranges.  at_most : of the objective in
    every case, or None.  fields : names of the d numbers.  lower, upper : (d,).
    cases : changes of the scenario, one mapping a case.
    """

    name: str
    title: str
    scenario: Scenario
    minimise: str
    at_most: float | None
    fields: tuple[str, ...]
    lower: Floats
    upper: Floats
    cases: tuple[Mapping[str, Any], ...]

    def of_case(self, case: Mapping[str, Any]) -> Scenario:
        """The scenario of a case, before the numbers are changed."""
        return replace(self.scenario, case) if case else self.scenario

    def values(self, shares: Floats) -> Floats:
        """Numbers (d,) at shares of their ranges."""
        return self.lower + np.clip(shares, 0.0, 1.0) * (self.upper - self.lower)

    def changed(self, scenario: Scenario, values: Floats) -> Scenario:
        """A scenario with other numbers."""
        document = whole_document(scenario)
        for field, value in zip(self.fields, values, strict=True):
            for place in places(scenario, document, field):
                set_at(document, place, float(value))
        return from_mapping(document, origin=scenario.origin, folder=scenario.folder)


def load_design(path: str | Path) -> Design:
    """Read and check the design study of a TOML file.

    Raises `ScenarioError`, which names table, key, value and how to mend it.
    """
    path = Path(path)
    if not path.is_file():
        raise ScenarioError(f"{path}: no such file; give the TOML file of a design study")
    return read_design(read_file(path), str(path), path.parent)


def read_design(
    document: Mapping[str, Any], origin: str = "design", folder: Path | None = None
) -> Design:
    """Check a document that has the names of a design study's file."""
    plain = plain_values(document)
    top = Table(plain, origin, "", _TOP)
    name = read_name(top)
    given = top.require("scenario", '"mrp-k4-rk4"')
    case = load((folder or Path()) / given if str(given).endswith(".toml") else given)
    fixed = dict(plain.get("fixed", {}))
    case = replace(case, fixed) if fixed else case
    minimise = top.choice("minimise", (MEAN, WORST, NUMBERS), MEAN)
    at_most = top.number("at_most") if "at_most" in top else None
    if minimise == NUMBERS and at_most is None:
        top.fail("at_most", "missing", "say what the objective may be at most, e.g. 25.0")
    entries = top.require("vary", "[{ field = ..., from = ..., to = ... }]")
    if not isinstance(entries, list) or not entries:
        top.fail("vary", "is no list of tables", "write one [[vary]] for every number")
    rows = [Table(row, origin, f"[[vary]] {k + 1}", _VARY) for k, row in enumerate(entries)]
    document = whole_document(case)
    fields = tuple(row.text("field") for row in rows)
    found: list[Place] = []
    for row, field in zip(rows, fields, strict=True):
        own = places(case, document, field)
        if any(place in found for place in own):
            row.fail("field", "is varied twice", "drop one of the two")
        found += own
    lower = np.array([row.number("from") for row in rows])
    upper = np.array([row.number("to") for row in rows])
    for row, low, high in zip(rows, lower, upper, strict=True):
        if not low < high:
            row.fail("to", f"is not above from = {low:g}", "give the larger number to `to`")
    cases = tuple(dict(case) for case in _cases(top, plain.get("cases", [{}])))
    title = top.text("title", case.title)
    design = Design(name, title, case, minimise, at_most, fields, lower, upper, cases)
    for changes in cases:  # bad ones fail before anything is solved
        for share in (0.0, 1.0):
            design.changed(design.of_case(changes), design.values(np.full(len(fields), share)))
    return design


def _cases(top: Table, entries: Any) -> Sequence[Mapping[str, Any]]:
    if (
        not isinstance(entries, list)
        or not all(isinstance(e, dict) for e in entries)
        or not entries
    ):
        top.fail("cases", "is no list of tables", "write one [[cases]] for every case")
    return [copy.deepcopy(entry) for entry in entries]
