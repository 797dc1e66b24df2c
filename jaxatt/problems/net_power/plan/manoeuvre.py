"""The manoeuvre that a task of a plan asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jaxatt.problems.net_power.manoeuvre import End, Manoeuvre, Motion, Satellite
from jaxatt.problems.net_power.plan.task import Task, goal
from jaxatt.problems.net_power.pose import Pose
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class Terms:
    """What holds for all harvests of a plan; see `Manoeuvre`."""

    terminal: str = "reach"
    attitude_weight: float = 0.0
    rate_weight: float = 0.0
    substeps: int | None = None
    floor: float = -np.inf


def task_manoeuvre(
    satellite: Satellite,
    tasks: Sequence[Task],
    index: int,
    start: Motion,
    charge: float,
    terms: Terms,
) -> Manoeuvre:
    """Manoeuvre of a task from where the one before ended.

    A harvest ends in the pose of the task after it; a task of prescribed attitude has no end to be
    reached, see `held_rate`.

    charge : [J], of the battery at the start.
    """
    task = tasks[index]
    return Manoeuvre(
        satellite=satellite,
        start=start,
        end=_end(tasks, index) if task.searched else None,
        start_time=task.start,
        duration=task.duration,
        intervals=task.intervals,
        load=task.load,
        terminal=terms.terminal,
        attitude_weight=terms.attitude_weight,
        rate_weight=terms.rate_weight,
        substeps=terms.substeps,
        floor=terms.floor,
        charge=charge,
    )


def _end(tasks: Sequence[Task], index: int) -> End | None:
    after = goal(tasks, index)
    if after is None:
        return None
    assert after.pose is not None
    return End(
        after.pose.q_ib,
        after.pose.omega_ib,
        after.attitude_tolerance,
        after.rate_tolerance,
        after.omega_bw,
    )


def held_rate(task: Task) -> Floats:
    """Rate (3,) [rad/s] in body axes at which a task of prescribed attitude turns."""
    return np.zeros(3) if task.pose is None else task.pose.omega_ib


def asked_pose(task: Task, start: Motion) -> Pose:
    """Pose in which a task of prescribed attitude has to begin; where it is, if none is given."""
    return task.pose or Pose(start.q_ib, np.zeros(3))
