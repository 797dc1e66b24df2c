"""Read the quantities that a study varies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.scenario import Scenario
from jaxatt.spacecraft.checks import as_float
from jaxatt.studies.sweep.numbers import EVERY, places, value_at
from jaxatt.studies.sweep.samples import Range
from jaxatt.studies.sweep.study import Varied
from jaxatt.studies.tables import VARY


def read_varied(
    data: Any,
    index: int,
    origin: str,
    kind: str,
    method: str,
    scenario: Scenario,
    whole: Mapping[str, Any],
) -> Varied:
    """Read one table of a study, the one of this index.

    kind : name of such tables, "vary" or "design".  method : of the samples.
    whole : document of the scenario, its vehicle written out.
    """
    table = Table(data, origin, f"[[{kind}]] no. {index + 1}", VARY)
    given = table.require("field")
    fields = given if isinstance(given, list) else [given]
    if not fields or not all(isinstance(field, str) for field in fields):
        table.fail("field", "is no name", "write the name of a number, or a list of such names")
    change = table.choice("change")
    try:
        found = [place for field in fields for place in places(scenario, whole, field)]
    except ScenarioError as error:
        raise ScenarioError(f"{table.where('field')}: {error}") from None
    if change != "set":
        for place in found:
            if value_at(whole, place) is None:
                table.fail(
                    "change", f"{scenario.name} leaves {fields[0]} out", 'use change = "set"'
                )
    name = table.text("name", _default_name(fields[0], change))
    return Varied(name, tuple(fields), tuple(found), change, _range(table, method))


def check_apart(varied: Sequence[Varied], origin: str, kind: str) -> None:
    """Refuse quantities that share a name, or set one number twice, with `ScenarioError`."""
    names = [v.name for v in varied]
    for k, one in enumerate(varied):
        if one.name in names[:k]:
            raise ScenarioError(
                f"{origin}: [[{kind}]] no. {k + 1} name = {one.name}: is the name of another one; "
                'give it a name of its own with name = "..."'
            )
        for other in varied[:k]:
            if one.change == other.change == "set" and set(one.places) & set(other.places):
                raise ScenarioError(
                    f"{origin}: [[{kind}]] no. {k + 1} field = {one.fields[0]}: is set by "
                    f"{other.name} already; drop one of them"
                )


def _default_name(field: str, change: str) -> str:
    parts = [part for part in field.split(".") if part != EVERY]
    last = max((k for k, part in enumerate(parts) if not part.isdecimal()), default=0)
    return "_".join(parts[last:]) + {"set": "", "multiply": "_factor", "add": "_added"}[change]


def _range(table: Table, method: str) -> Range:
    if "values" in table:
        return _listed(table)
    low, high = table.number("from"), table.number("to")
    if not high > low:
        table.fail("to", f"is not above from = {low:g}", "exchange the two")
    whole = table.flag("whole")
    if whole and not (low.is_integer() and high.is_integer()):
        table.fail("whole", "from and to are no whole numbers", "give whole numbers")
    logarithmic = table.choice("spacing") == "logarithmic"
    if logarithmic and (low <= 0.0 or whole):
        table.fail("spacing", "needs from above zero, and no whole", 'use spacing = "linear"')
    if method == "grid":
        count = table.integer("count")
    elif "count" in table:
        table.fail("count", f'has no meaning for method = "{method}"', "write samples instead")
    else:
        count = 0
    return Range(None, low, high, count, logarithmic, whole)


def _listed(table: Table) -> Range:
    given = table.data["values"]
    if not isinstance(given, list) or not given:
        table.fail("values", "is no list of numbers", "write numbers in brackets")
    try:
        values = np.array([as_float(value) for value in given])
    except TypeError:
        table.fail("values", "holds something that is no number", "give plain numbers")
    if not np.isfinite(values).all():
        table.fail("values", "holds a number that is not finite", "give finite numbers")
    if len(np.unique(values)) < len(values):
        table.fail("values", "holds a number twice", "keep one of them")
    return Range(values, whole=all(isinstance(value, int) for value in given))
