"""Whether the wheels are strong enough for a turn, by a bound that no torque can beat."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from jaxatt.problems.net_power.plan.task import Task, goal
from jaxatt.problems.net_power.pose import Pose, angle_between
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import Spacecraft

_SLACK = 1.02
"""For external torques, which are left out."""


def check_reach(
    tasks: Sequence[Task], craft: Spacecraft, initial: Pose | None, origin: str
) -> None:
    """Refuse a harvest that is too short to turn from the task before it to the one after.

    initial : pose at the start of the plan; None where it is not known.  Raises `ScenarioError`.
    """
    now = initial
    for index, task in enumerate(tasks):
        if not task.searched:
            now = None if task.pose is None else task.pose.after(task.duration)
            continue
        after = goal(tasks, index)
        if after is None or after.pose is None or now is None:
            continue
        turn = angle_between(now.q_ib, after.pose.q_ib)
        most = farthest_turn(craft, now.omega_ib, after.pose.omega_ib, task.duration)
        if turn > most + after.attitude_tolerance:
            raise ScenarioError(
                f'{origin}: [[tasks]] no. {index + 2} "{after.name}": cannot be reached: the turn '
                f"to it takes {math.degrees(turn):.4g} deg, and in the {task.duration:g} s of "
                f'"{task.name}" the wheels turn the body by at most {math.degrees(most):.3g} deg; '
                "begin it later, end the task before it earlier, or mount stronger wheels"
            )


def farthest_turn(craft: Spacecraft, before: Floats, after: Floats, duration: float) -> float:
    """Angle [rad] beyond which no torques of the wheels turn the body in a time [s].

    before, after : (3,) [rad/s], rates at the beginning and at the end.  Zero where the rates alone
    cannot be changed in that time.

    With v = sqrt(omega' J_s omega) the momentum of the wheels, whatever it is, does no work, so
    that |dv/dt| <= max sqrt(tau' J_s^-1 tau); and the rate is at most v over the root of the least
    principal moment of J_s.
    """
    inertia, wheels = np.asarray(craft.inertia_without_spin), craft.wheels
    corners = itertools.product((-1.0, 1.0), repeat=wheels.count)
    torques = np.array(list(corners)) * np.asarray(wheels.torque_limit) @ np.asarray(wheels.axes).T
    squared = np.einsum("ki,ij,kj->k", torques, np.linalg.inv(inertia), torques)
    rise = _SLACK * math.sqrt(float(squared.max()))
    first, last = (math.sqrt(float(w @ inertia @ w)) for w in (before, after))
    rising = 0.5 * (duration + (last - first) / rise)
    if not 0.0 <= rising <= duration:
        return 0.0
    falling = duration - rising
    swept = first * rising + last * falling + 0.5 * rise * (rising**2 + falling**2)
    return float(swept / math.sqrt(float(np.linalg.eigvalsh(inertia)[0])))
