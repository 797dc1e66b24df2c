"""A plan as data: tasks that follow one another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from jaxatt.problems.net_power.plan.modes import HARVEST
from jaxatt.problems.net_power.pose import Pose
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True)
class Site:
    """A place on the ground: geodetic latitude and longitude [rad], at height zero."""

    latitude: float
    longitude: float


@dataclass(frozen=True, eq=False)
class Task:
    """One task of a plan.

    mode : one of `modes.MODES`.  start, duration : [s], since the epoch of the plan.
    intervals : of control, of equal length.
    pose : with which the task begins, and at whose rate it goes on; None for a harvest, and for an
    idle that waits where it is.
    attitude_tolerance [rad], rate_tolerance [rad/s] : within which the task has to begin.
    omega_bw : (n,) [rad/s], wheel speeds to begin with; None where any will do.
    load : [W], of the other subsystems.
    site : place that must be in sight throughout; None where nothing is looked at.
    """

    name: str
    mode: str
    start: float
    duration: float
    intervals: int
    pose: Pose | None = None
    attitude_tolerance: float = math.radians(0.1)
    rate_tolerance: float = 1e-4
    omega_bw: Floats | None = None
    load: float = 0.0
    site: Site | None = None

    @property
    def end(self) -> float:
        """[s], since the epoch of the plan."""
        return self.start + self.duration

    @property
    def searched(self) -> bool:
        """Whether the attitude is free on the way, so that there is something to optimise."""
        return self.mode == HARVEST


def goal(tasks: Sequence[Task], index: int) -> Task | None:
    """The task in whose pose a harvest has to end; None where it may end anywhere."""
    return tasks[index + 1] if index + 1 < len(tasks) else None
