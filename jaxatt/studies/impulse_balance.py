"""Lower bound on the time for which thrusters must fire in a rest-to-rest turn.

The angular momentum grows no faster than the largest torque while valves are open, stays while
they are shut, and is zero at both ends.  So it is at most that torque times the smaller of the open
time before and the open time after, the rate is at most that over the least moment of inertia, and
its integral is at least the angle turned: with x half the open time, angle <= torque / inertia *
x (T - x).  No slew can do with less, about whatever axes.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.vehicle import Spacecraft

_MANY = 12


def largest_torque(craft: Spacecraft) -> float:
    """Norm [N m] of the largest torque that the thrusters can give together."""
    limit = np.asarray(craft.thrusters.torque_limit)
    pushes = np.asarray(craft.thrusters.distribution) * limit
    if pushes.shape[1] > _MANY:
        return float(np.linalg.norm(pushes, axis=0).sum())
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=pushes.shape[1])))
    return float(np.linalg.norm(corners @ pushes.T, axis=1).max())


def _open_time(angle: float, acceleration: float, duration: float) -> float:
    left = duration**2 - 4.0 * angle / acceleration if acceleration > 0.0 else -1.0
    return math.inf if left < 0.0 else duration - math.sqrt(left)


def least_on_time(craft: Spacecraft, turn: Floats, duration: float) -> float:
    """Least time [s] with any valve open for a rest-to-rest turn; inf where none suffices.

    turn : (3,) [rad], rotation vector of the turn.  duration : [s].
    Holds for vehicles whose wheels, if any, stay still.
    """
    least = float(np.linalg.eigvalsh(np.asarray(craft.inertia)).min())
    return _open_time(float(np.linalg.norm(turn)), largest_torque(craft) / least, duration)


def eigenaxis_on_time(craft: Spacecraft, turn: Floats, duration: float) -> float:
    """As `least_on_time`, for a turn about a fixed axis with valves that switch at any instant.

    Slews about several axes may do with a little less.  The torque along the inertia times the axis
    is the largest that pairs of opposed thrusters along body axes give; gyroscopic torque is left
    out, which is small for nearly equal moments of inertia.
    """
    axis = np.asarray(turn) / np.linalg.norm(turn)
    wanted = np.asarray(craft.inertia) @ axis
    limit = np.asarray(craft.thrusters.torque_limit)
    pushes = np.asarray(craft.thrusters.distribution) * limit
    ahead = np.maximum(pushes, 0.0).sum(axis=1)
    back = np.maximum(-pushes, 0.0).sum(axis=1)
    reach = np.where(wanted > 0.0, ahead, back)
    needed = np.abs(wanted) > 1e-12 * np.abs(wanted).max()
    acceleration = float((reach[needed] / np.abs(wanted[needed])).min())
    return _open_time(float(np.linalg.norm(turn)), acceleration, duration)


def least_intervals(craft: Spacecraft, turn: Floats, duration: float, step: float) -> int:
    """Fewest intervals of `step` [s] that hold `least_on_time`; more than there are if none do.

    Torque is constant within an interval, which is part of it or all of it.
    """
    time = least_on_time(craft, turn, duration)
    if not math.isfinite(time):
        return math.floor(duration / step + 0.5) + 1
    return math.ceil(time / step - 1e-9)
