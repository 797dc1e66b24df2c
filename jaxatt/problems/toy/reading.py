"""Read the scenario of a toy system from a TOML document."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.hands_off.reading.objective import PRINTED, check_free_time
from jaxatt.problems.hands_off.reading.windows import read_windows
from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.reading import settings
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.heading import read_heading
from jaxatt.problems.scenario import Control, Objective, Scenario
from jaxatt.problems.toy.tables import TOY_TABLES

_NO_ATTITUDE = np.array([1.0, 0.0, 0.0, 0.0])


def read_toy(
    document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    heading = faults.of(read_heading, document, origin, TOY_TABLES, PRINTED)
    objective = faults.of(_read_objective, document.get("objective", {}), origin)
    horizon = faults.of(settings.read_horizon, faults.table(document, "horizon"), origin)
    faults.of(check_free_time, document, origin, horizon, objective)
    windows = faults.of(read_windows, document.get("windows", []), origin, horizon)
    faults.refuse()
    notes: list[str] = []
    if objective.kind == "moving-l0" and all(window.forbidden for window in windows):
        notes.append("moving-l0 without a cheap window is the same as l0; add [[windows]]")
    initial = Table(document["initial"], origin, "[initial]", TOY_TABLES["initial"])
    target = Table(document.get("target", {}), origin, "[target]", TOY_TABLES["target"])
    control = Table(document.get("control", {}), origin, "[control]", TOY_TABLES["control"])
    return Scenario(
        **vars(heading),
        family="toy",
        initial=InitialState(_NO_ATTITUDE, np.zeros(3), np.zeros(0), initial.vector("state")),
        targets=(
            Target(
                _NO_ATTITUDE,
                np.zeros(3),
                math.pi,
                math.inf,
                target.vector("state"),
                target.number("tolerance"),
            ),
        ),
        horizon=horizon,
        control=Control("body", control.number("limit")),
        objective=objective,
        windows=windows,
        notes=tuple(notes),
        document=document,
        origin=origin,
        folder=folder,
    )


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
