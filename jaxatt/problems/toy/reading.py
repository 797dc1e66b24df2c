"""Read the scenario of a toy system from a TOML document."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.scenario import Control, Scenario
from jaxatt.problems.toy.reading_parts import read_parts
from jaxatt.problems.toy.tables import TOY_TABLES

_NO_ATTITUDE = np.array([1.0, 0.0, 0.0, 0.0])


def read_toy(
    document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    notes: list[str] = []
    heading, objective, horizon, windows = read_parts(document, origin, folder, notes, faults)
    faults.refuse()
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
