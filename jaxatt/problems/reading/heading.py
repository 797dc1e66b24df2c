"""Read what every scenario has: name, title, source, solver, printed values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES, top_level_keys
from jaxatt.problems.scenario import SPACECRAFT, SolverSettings

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]*")


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
) -> Heading:
    """Read the heading of a document whose top level holds these tables.

    required : tables that must be there.
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
    name = top.text("name", Path(origin).stem)
    if not _NAME.fullmatch(name):
        top.fail("name", "must serve as a file name", "use letters, digits, '-', '_' and '.'")
    printed = document.get("printed", {})
    if not isinstance(printed, dict):
        top.fail("printed", "is not a table", "write [printed] and its keys below")
    return Heading(
        name,
        top.text("title", name),
        top.text("source", "not stated"),
        system,
        read_solver(document.get("solver", {}), origin),
        printed,
    )


def read_solver(data: Any, origin: str) -> SolverSettings:
    """Read the number of starts and the seed."""
    table = Table(data, origin, "[solver]", SPACECRAFT_TABLES["solver"])
    return SolverSettings(
        starts=table.integer("starts", 64), seed=table.integer("seed", 0, at_least=0)
    )
