"""Flight of a slew's answer: series, references, verdict and cones."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.flown import flown_end, flown_series
from jaxatt.problems.hands_off.null_torque import NullTorque, null_torque
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Flown
from jaxatt.problems.motor_torques import motor_torque
from jaxatt.records.pointing import PointingRecord
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight import Trajectory
from jaxatt.simulation.flight_error import fly_until_agreed
from jaxatt.spacecraft.wheel_bias import null_momenta


def fly_slew(task: SlewTask, controls: Floats) -> Flown:
    """Fly torques (1, N, b) of a slew on the full model and judge the flight.

    Where a bias of the wheels is asked for, the torques that bring it about are added.
    """
    bias = None
    if task.target.wheel_bias is not None:
        bias = _bias_torque(task, controls)
        task = task.adding(bias.torque)
    flown, flight_error = fly_until_agreed(
        lambda times: task.fly(controls, times),
        task.flights.steps,
        task.tolerances,
        task.intervals,
    )
    series = flown_series(flown)
    if task.craft.wheels.count:
        series["torque_body"] = task.body_torque(controls[0])
        series["torque_wheels"] = task.wheel_torque(controls[0])
        if not task.craft.wheels.motors.ideal:
            series["torque_motors"] = motor_torque(
                task.craft.wheels, series["torque_wheels"], _speeds(task, flown)[0]
            )
    if task.craft.thrusters.count:
        series["torque_thrusters"] = task.thrust(controls[0])
    reference = task.target.facing(np.asarray(flown.q_ob)[0, task.intervals]).reference()
    if task.waypoint is not None:
        reference["waypoint"] = task.waypoint.q_ob
    if task.target.wheel_bias is not None:
        reference["wheel_bias"] = task.target.wheel_bias
    cost = task.cost(flown, controls)
    if bias is not None and "sparsity" in cost:
        weight = np.asarray(task.arguments.weight)
        cost["sparsity"] = cost["sparsity"] + task.goal.weights.sparsity * weight[bias.added].sum()
    return Flown(
        task.judge(flown, controls),
        cost,
        series,
        reference,
        flown_end(flown, task.intervals),
        _pointing(task, flown),
        flight_error,
        _speeds(task, flown),
        bias,
    )


def _bias_torque(task: SlewTask, controls: Floats) -> NullTorque:
    """Torques that lead the wheels of an answer (1, N, b) to the bias that is asked for.

    They turn nothing, so a flight without them says by how much the bias is to change.
    """
    wheels, end = task.craft.wheels, task.intervals
    speeds = np.asarray(task.fly(controls).omega_bw[0, end])
    basis = null_momenta(wheels)
    impulse = basis.T @ (np.asarray(wheels.inertia) * (task.target.wheel_bias - speeds))
    held = task.wheel_torque(controls)[0]
    used = np.any(held != 0.0, axis=1)
    weight, free = np.asarray(task.arguments.weight), np.asarray(task.arguments.free)
    near = [int(np.abs(np.flatnonzero(used) - k).min(initial=end)) for k in range(end)]
    idle = [k for k in range(end) if free[k].any() and not used[k]]
    order = sorted(idle, key=lambda k: (weight[k], near[k], k))
    return null_torque(basis, impulse, held, np.asarray(wheels.torque_limit), task.step, order)


def _speeds(task: SlewTask, flown: Trajectory) -> tuple[Floats, float]:
    """Wheel speeds (T, n) [rad/s] of a flight (S = 1), and the time [s] between two of them."""
    speeds, step = task.wheel_speeds(flown)
    return speeds[0], step


def _pointing(task: SlewTask, flown: Trajectory) -> PointingRecord | None:
    """Record of cones and rate limits along a flight (S = 1)."""
    if not task.pointing:
        return None
    path_monitor, times = task.path_monitor, task.path_monitor.elapsed
    constraint_margin = (
        np.zeros(len(task.pointing.cones) + 1)
        if task.constraint_margin is None
        else task.constraint_margin
    )
    return PointingRecord(
        time=times,
        angles=path_monitor.watch(flown).angles[0],
        boresights=path_monitor.boresights(flown),
        directions=path_monitor.directions,
        extremes=task.watch(flown).extremes(times),
        constraint_margin=constraint_margin[:-1],
    )
