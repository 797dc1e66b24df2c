"""Read what every scenario has: name, title, source, solver, printed values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.names import read_name
from jaxatt.problems.reading.printed import PrintedNumbers, read_printed
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES, top_level_keys
from jaxatt.problems.scenario import SPACECRAFT, SolverSettings

MOST_STARTS, MOST_SEED = 1_000_000, 2**31 - 1
"""Starts whose outcomes fit into memory, and the largest seed."""


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
    tables: Mapping[str, tuple[str, ...]],
    required: tuple[str, ...],
    printed: Mapping[str, PrintedNumbers] | None = None,
    printed_rows: PrintedNumbers | None = None,
) -> Heading:
    """Read the heading of a document whose top level holds these tables.

    required : tables that must be there.
    printed, printed_rows : what [printed] may hold that is compared, see `read_printed`.
    """
    top = Table(document, origin, "", top_level_keys({**SPACECRAFT_TABLES, **tables}))
    system = top.text("system", SPACECRAFT)
    for key in document:
        if key not in top_level_keys(tables):
            raise ScenarioError(f"{origin}: {key}: has no meaning for system = {system}; drop it")
    for key in required:
        if key not in document:
            raise ScenarioError(
                f"{origin}: [{key}] is missing; `jaxatt scenarios show NAME` prints"
                " a complete file to start from"
            )
    name = read_name(top)
    return Heading(
        name,
        top.text("title", name),
        top.text("source", "not stated"),
        system,
        read_solver(document.get("solver", {}), origin),
        read_printed(document.get("printed", {}), origin, printed or {}, printed_rows),
    )


def read_solver(data: Any, origin: str) -> SolverSettings:
    """Read the number of starts and the seed."""
    table = Table(data, origin, "[solver]", SPACECRAFT_TABLES["solver"])
    return SolverSettings(
        starts=table.integer("starts", 64, at_most=MOST_STARTS),
        seed=table.integer("seed", 0, at_least=0),
    )
