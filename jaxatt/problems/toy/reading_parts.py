"""Read the parts of a toy system's scenario that take no computing, and so no JAX."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from jaxatt.problems.hands_off.reading.objective import PRINTED, check_free_time
from jaxatt.problems.hands_off.reading.windows import read_windows
from jaxatt.problems.reading import settings
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.heading import Heading, read_heading
from jaxatt.problems.scenario_parts import Horizon, Objective, Window
from jaxatt.problems.toy.tables import TOY_TABLES


class Parts(NamedTuple):
    """What was read."""

    heading: Heading
    objective: Objective
    horizon: Horizon
    windows: tuple[Window, ...]


def read_parts(
    document: dict[str, Any], origin: str, folder: Path | None, notes: list[str], faults: Faults
) -> Parts:
    """Read the parts; arguments as for `Family.read`, and notes, to which remarks are added."""
    heading = faults.of(read_heading, document, origin, TOY_TABLES, PRINTED)
    objective = faults.of(_read_objective, document.get("objective", {}), origin)
    horizon = faults.of(settings.read_horizon, faults.table(document, "horizon"), origin)
    faults.of(check_free_time, document, origin, horizon, objective)
    windows = faults.of(read_windows, document.get("windows", []), origin, horizon)
    return Parts(heading, objective, horizon, windows)


def _read_objective(data: Any, origin: str) -> Objective:
    table = Table(data, origin, "[objective]", TOY_TABLES["objective"])
    kind = table.choice("kind")
    if table.choice("terminal") == "penalty":
        table.fail("terminal", "the toy systems have no printed penalty", 'use terminal = "reach"')
    return Objective(
        kind=kind,
        epsilon=table.number("epsilon"),  # section 3.7.5
        time_weight=table.number("time_weight_1_s"),
    )
