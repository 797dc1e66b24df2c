"""Flight of a toy's answer."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.hands_off.task import Flown
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.toy.task import ToyTask
from jaxatt.runtime.arrays import Floats

_NO_ATTITUDE = np.array([1.0, 0.0, 0.0, 0.0])


def fly_toy(task: ToyTask, controls: Floats) -> Flown:
    """Simulate controls (1, N, 1) again with fine steps and judge them."""
    verdict, cost = task.verify(controls)
    states = task.fly(controls)[0]
    return Flown(
        verdict,
        cost,
        {"state": states, "control": controls[0]},
        {"state": np.asarray(task.parameters.target)},
        InitialState(_NO_ATTITUDE, np.zeros(3), np.zeros(0), states[-1]),
    )
