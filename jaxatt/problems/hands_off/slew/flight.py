"""Flight of a slew's answer: series, references, verdict and cones."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.flown import flown_end, flown_series
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import Flown
from jaxatt.records.pointing import PointingRecord
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.flight import Trajectory
from jaxatt.simulation.flight_error import fly_until_agreed


def fly_slew(task: SlewTask, controls: Floats) -> Flown:
    """Fly torques (1, N, b) of a slew on the full model and judge the flight."""
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
    if task.craft.thrusters.count:
        series["torque_thrusters"] = task.thrust(controls[0])
    reference = {"q_ob": task.target.q_ob, "omega_ob": task.target.omega_ob}
    if task.waypoint is not None:
        reference["waypoint"] = task.waypoint.q_ob
    return Flown(
        task.judge(flown, controls),
        task.cost(flown, controls),
        series,
        reference,
        flown_end(flown, task.intervals),
        _pointing(task, flown),
        flight_error,
    )


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
