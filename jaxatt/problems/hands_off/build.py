"""Build the tasks of a scenario."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.coasting import needed_substeps
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Goal, Weights
from jaxatt.problems.hands_off.windows import forbidden_mask, window_weights
from jaxatt.problems.manoeuvre import Grid, InitialState
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.surroundings import surroundings_of


def goal_of(scenario: Scenario) -> Goal:
    """Objective of a scenario, with its weights."""
    o = scenario.objective
    weights = Weights(
        o.rate_weight,
        o.attitude_weight,
        o.sparsity_weight,
        o.waypoint_weight,
        o.on_off_weight,
        o.on_off_form == "printed",
    )
    return Goal(o.kind, o.terminal, o.design, o.epsilon, weights)


def build_slew(
    scenario: Scenario,
    phase: int = 0,
    initial_state: InitialState | None = None,
    enforce_speed_limits: bool = True,
    final_time: float | None = None,
    start_time: float | None = None,
) -> SlewTask:
    """SparseTask of one phase of a scenario.

    phase : index into `scenario.targets`.  initial_state : where the phase begins, by default where
    the scenario does; successive phases hand over the flown end of the one before.
    enforce_speed_limits : False to leave wheel speed limits to the verdict.
    final_time : [s] from the phase's start, by default the scenario's horizon.
    start_time : [s] at which the phase starts, by default after as many horizons as there are
    phases before it.
    """
    horizon, target, goal = scenario.horizon, scenario.targets[phase], goal_of(scenario)
    duration = horizon.duration if final_time is None else final_time
    assert scenario.vehicle is not None
    surroundings, substeps = surroundings_of(scenario), horizon.substeps
    if horizon.free and substeps is None:
        # As many as the longest interval needs: with the same number everywhere nothing recompiles.
        substeps = needed_substeps(
            scenario.vehicle,
            initial_state or scenario.initial,
            target,
            surroundings,
            horizon.longest / horizon.intervals,
            horizon.intervals,
        )
    moving = goal.kind == "moving-l0"
    return SlewTask(
        craft=scenario.vehicle,
        surroundings=surroundings,
        initial_state=initial_state or scenario.initial,
        target=target,
        grid=Grid(
            horizon.intervals,
            duration / horizon.intervals,
            horizon.coast_intervals,
            phase * horizon.duration if start_time is None else start_time,
            substeps,
        ),
        goal=goal,
        weight=window_weights(scenario) if moving else np.ones(horizon.intervals),
        forbidden=forbidden_mask(scenario),
        waypoint=scenario.waypoint,
        axes=scenario.control.axes,
        enforce_speed_limits=enforce_speed_limits,
        pointing=scenario.pointing,
    )
