"""Build the task of a toy's scenario."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.hands_off.build import goal_of
from jaxatt.problems.hands_off.windows import forbidden_mask, window_weights
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.toy.task import ToyTask


def build_toy(
    scenario: Scenario,
    initial_state: InitialState | None = None,
    enforce_speed_limits: bool = True,
    final_time: float | None = None,
) -> ToyTask:
    """Build the task of a toy's scenario.

    initial_state : where it begins, by default where the scenario does.
    enforce_speed_limits : without effect, there are no wheels.
    final_time : [s], by default the scenario's horizon.
    """
    horizon, target, goal = scenario.horizon, scenario.targets[0], goal_of(scenario)
    duration = horizon.duration if final_time is None else final_time
    return ToyTask(
        scenario.system,
        (initial_state or scenario.initial).state,
        target.state,
        horizon.intervals,
        duration / horizon.intervals,
        scenario.control.limit,
        target.state_tolerance,
        goal,
        window_weights(scenario) if goal.kind == "moving-l0" else np.ones(horizon.intervals),
        forbidden_mask(scenario),
        horizon.substeps or 2,
    )
