"""Verdict on tasks of prescribed attitude: whether they begin as asked, within all limits."""

from __future__ import annotations

import dataclasses

import numpy as np

from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.judge import SPEED_TOLERANCE, judge_flight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.plan.manoeuvre import asked_pose
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.pose import angle_between
from jaxatt.problems.verdict import Verdict


def judge_held(task: Task, manoeuvre: Manoeuvre, flown: PoweredFlight) -> Verdict:
    """Judge the flight of one task.

    Errors, at the beginning: "attitude" [rad] and "rate" [rad/s], and where wheel speeds are asked
    for "wheel speed" [rad/s].  Limits of torque, speed and charge as in `judge_flight`.
    """
    start, asked = manoeuvre.start, asked_pose(task, manoeuvre.start)
    errors = {
        "attitude": angle_between(asked.q_ib, start.q_ib),
        "rate": float(np.linalg.norm(start.omega_ib - asked.omega_ib)),
    }
    tolerances = {"attitude": task.attitude_tolerance, "rate": task.rate_tolerance}
    if task.omega_bw is not None:
        errors["wheel speed"] = float(np.abs(start.omega_bw - task.omega_bw).max())
        tolerances["wheel speed"] = SPEED_TOLERANCE
    limits = judge_flight(manoeuvre, flown)
    return dataclasses.replace(
        limits,
        errors={name: np.array([value]) for name, value in errors.items()},
        tolerances=tolerances,
    )
