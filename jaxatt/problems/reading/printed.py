"""Read the table [printed]: what the source prints, to be set beside the package's own values."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.keys import Key, Number, TableKey
from jaxatt.problems.reading.schema import unit_of

_PERCENT = Number(at_least=0.0, at_most=100.0)

PrintedNumbers = Mapping[str, int]
"""Name of a value -> how many numbers it has."""


def read_printed(
    data: Any,
    origin: str,
    blocks: Mapping[str, PrintedNumbers],
    rows: PrintedNumbers | None = None,
    label: str = "[printed]",
) -> Mapping[str, Any]:
    """Check what is compared; whatever else the table holds is for the reader of the file.

    blocks : name of a table in [printed], such as an objective, -> its numbers.
    rows : numbers of each of the [[printed.rows]], which have a label; None where rows are free.
    label : what messages call the table.
    Raises `ScenarioError`.
    """
    top, faults = _table(data, origin, label), Faults()
    for name, numbers in blocks.items():
        if name in top:
            faults.of(_check, top.data[name], origin, f"{label[:-1]}.{name}]", numbers)
    if rows is not None and "rows" in top:
        listed = top.data["rows"]
        if not isinstance(listed, list):
            raise ScenarioError(
                f"{origin}: [printed] rows: must be a list of tables; write [[printed.rows]] with "
                "double brackets"
            )
        for index, item in enumerate(listed):
            faults.of(_check_row, item, origin, f"[[printed.rows]] no. {index + 1}", rows)
    faults.refuse()
    return top.data


def _table(
    data: Any, origin: str, label: str, numbers: PrintedNumbers = MappingProxyType({})
) -> Table:
    """A table that may hold any key, and some numbers."""
    keys = {name: _PERCENT if unit_of(name) == "percent" else Number() for name in numbers}
    return Table(data, origin, label, TableKey(keys_=keys, free=Key()))


def _check_row(data: Any, origin: str, label: str, numbers: PrintedNumbers) -> None:
    _table(data, origin, label).text("label")
    _check(data, origin, label, numbers)


def _check(data: Any, origin: str, label: str, numbers: PrintedNumbers) -> None:
    table = _table(data, origin, label, numbers)
    for name, count in numbers.items():
        if name in table and count > 1:
            table.vector(name, count)
        elif name in table:
            table.number(name)
