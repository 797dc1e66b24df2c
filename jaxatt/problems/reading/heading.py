"""Read what every scenario has: name, title, source, solver, printed values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.names import read_name
from jaxatt.problems.reading.printed import PrintedNumbers, read_printed
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES, Tables, scenario_keys
from jaxatt.problems.scenario_parts import SolverSettings


@dataclass(frozen=True)
class Heading:
    """Fields of `Scenario` that do not depend on its problem."""

    name: str
    title: str
    source: str
    system: str
    solver: SolverSettings
    printed: Mapping[str, Any]


def read_heading(
    document: dict[str, Any],
    origin: str,
    tables: Tables,
    printed: Mapping[str, PrintedNumbers] | None = None,
    printed_rows: PrintedNumbers | None = None,
) -> Heading:
    """Read the heading of a document whose top level holds these tables.

    printed, printed_rows : what [printed] may hold that is compared, see `read_printed`.
    """
    faults = Faults()
    words = faults.of(_words, faults.of(Table, document, origin, "", scenario_keys(tables)))
    solver = faults.of(read_solver, document.get("solver", {}), origin)
    values = faults.of(
        read_printed, document.get("printed", {}), origin, printed or {}, printed_rows
    )
    faults.refuse()
    return Heading(*words, solver, values)


def _words(top: Table) -> tuple[str, str, str, str]:
    """Name, title, source and system."""
    name = read_name(top)
    return name, top.text("title", name), top.text("source", "not stated"), top.text("system")


def read_solver(data: Any, origin: str) -> SolverSettings:
    """Read the number of starts and the seed."""
    table = Table(data, origin, "[solver]", SPACECRAFT_TABLES["solver"])
    return SolverSettings(
        starts=table.integer("starts"),
        seed=table.integer("seed"),
    )
