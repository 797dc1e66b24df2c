"""Runge-Kutta steps an interval that a manoeuvre needs, from what turns in it."""

from __future__ import annotations

import numpy as np

from jaxatt.attitude.host_turns import conjugate, product
from jaxatt.environment.table import Surroundings
from jaxatt.problems.manoeuvre import InitialState, Target, automatic_substeps
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.step_error import steps_needed
from jaxatt.spacecraft.vehicle import Spacecraft

_SHARE = 0.1
"""Of the tolerances at the end, what the steps alone may be wrong by."""


def needed_substeps(
    craft: Spacecraft,
    initial_state: InitialState,
    target: Target,
    surroundings: Surroundings,
    step: float,
    intervals: int,
) -> int:
    """RK4 steps an interval of `step` [s], for a known torque and for what turns."""
    known = automatic_substeps(step, surroundings)
    return max(known, coasting_substeps(craft, initial_state, target, step, intervals))


def coasting_substeps(
    craft: Spacecraft, initial_state: InitialState, target: Target, step: float, intervals: int
) -> int:
    """RK4 steps an interval of `step` [s], for what turns.

    Their error is measured on three motions without torque (`steps_needed`): the one that the
    manoeuvre begins with, and turns to the target at constant rates, both ways round.
    """
    rate = coasting_rates(initial_state, target, step * intervals)
    inertia, wheels = np.asarray(craft.inertia), craft.wheels
    stored = np.asarray(wheels.axes) @ (np.asarray(wheels.inertia) * initial_state.omega_bw)
    # Wheels exchange momentum with the body, thrusters change it.
    momentum = rate @ inertia + stored
    if wheels.count and not craft.thrusters.count:
        momentum = np.broadcast_to(momentum[:1], momentum.shape)
    within = (_SHARE * target.attitude_tolerance, _SHARE * target.rate_tolerance)
    body = np.asarray(craft.inertia_without_spin)
    return steps_needed(body, rate, momentum, step, intervals, within)


def coasting_rates(initial_state: InitialState, target: Target, duration: float) -> Floats:
    """Initial rate, and constant rates to the target the short and the long way, (3, 3) [rad/s]."""
    begin = np.asarray(initial_state.q_ob)
    turn = product(conjugate(begin), np.asarray(target.q_ob))
    turn = turn if turn[0] >= 0.0 else -turn
    length = float(np.linalg.norm(turn[1:]))
    angle = 2.0 * np.arctan2(length, turn[0])
    axis = turn[1:] / length if length > 0.0 else np.zeros(3)
    away = 2.0 * np.pi - angle
    return np.stack([initial_state.omega_ob, angle / duration * axis, -away / duration * axis])
