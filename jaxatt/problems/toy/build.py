"""Build the task of a toy's scenario."""

from __future__ import annotations

from jaxatt.problems.hands_off.build import goal_of
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
    horizon, target = scenario.horizon, scenario.targets[0]
    duration = horizon.duration if final_time is None else final_time
    return ToyTask(
        scenario.system,
        (initial_state or scenario.initial).state,
        target.state,
        horizon.intervals,
        duration / horizon.intervals,
        scenario.control.limit,
        target.state_tolerance,
        goal_of(scenario),
        horizon.substeps or 2,
    )
