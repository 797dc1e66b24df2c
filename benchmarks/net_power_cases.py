"""Manoeuvres of the comparison with IPOPT, from the bundled scenarios.

"chapter-4" is the whole of `hypso1-netpower`; "task-7" is the harvest of 4380 s in `hypso2-orbit`,
from the pose in which the imaging before it ends and the wheels at their reference speeds.
"""

from __future__ import annotations

import numpy as np

from jaxatt import scenarios
from jaxatt.attitude import quaternion
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.build import manoeuvre_of, options_of
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Motion
from jaxatt.problems.net_power.plan.manoeuvre import Terms, task_manoeuvre

CASES = ("chapter-4", "task-7")


def manoeuvre(case: str) -> Manoeuvre:
    """Manoeuvre of a case.  Raises `ValueError` for a name that is not in `CASES`."""
    if case not in CASES:
        raise ValueError(f"case = {case!r}: choose one of {', '.join(CASES)}")
    if case == "chapter-4":
        return manoeuvre_of(scenarios.load("hypso1-netpower"), PhaseStart())
    options = options_of(scenarios.load("hypso2-orbit"))
    harvests = [index for index, task in enumerate(options.tasks) if task.searched]
    index = harvests[6]
    before, satellite = options.tasks[index - 1], options.satellite
    assert before.pose is not None and satellite.momentum is not None
    turn = np.asarray(before.pose.omega_ib) * before.duration
    q_ib = np.asarray(quaternion.multiply(before.pose.q_ib, quaternion.from_rotation_vector(turn)))
    start = Motion(q_ib, before.pose.omega_ib, satellite.momentum.wheel_speed)
    return task_manoeuvre(satellite, options.tasks, index, start, 0.0, Terms())
