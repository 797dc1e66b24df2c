"""Variables that a turn in free time adds to an archive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jaxatt.problems.time_optimal.record import time_optimum
from jaxatt.records.labels import Variable, labelled
from jaxatt.records.phase import Phase


def variables(phase: Phase, phases: Sequence[Phase]) -> dict[str, Variable]:
    """Variables of the optimality and of the outcome of every start."""
    optimum, count = time_optimum(phase), len(phase.active)
    start, along = ("start",), ("interval",)
    return {
        "weight": labelled(np.ones(count), along, "1", "cost of the interval if active"),
        "window": labelled(np.zeros(count, bool), along, "", "whether in a cheap window"),
        "forbidden": labelled(np.zeros(count, bool), along, "", "whether torque is forbidden"),
        "start_cost": labelled(optimum.start_costs, start, "s", "cost at the end"),
        "start_final_time": labelled(optimum.start_times, start, "s", "final time"),
        "cost": labelled(optimum.cost, (), "s", "time and weighted effort"),
        "kkt_violation": labelled(optimum.violation, (), "1", "largest violation"),
        "kkt_stationarity": labelled(optimum.stationarity, (), "1", "Lagrangian's gradient"),
        "share_at_best": labelled(optimum.share, (), "1", "share of starts at the best minimum"),
        "own_error": labelled(
            optimum.own_error, (), "rad", "attitude error where the transcription ends"
        ),
    }
