"""Minimum time with friction and torque that falls with speed, beside CasADi and IPOPT."""

import functools

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.search import search_free_time
from jaxatt.spacecraft.wheel_motor import FRICTION_WIDTH

INTERVALS, SUBSTEPS = 16, 2
COULOMB, VISCOUS, FULL, NONE = 2e-4, 8e-6, 25.0, 70.0


@functools.cache
def turned(ideal=False):
    """Task and best answer of a turn with motors as above, or with ideal ones."""
    motors = {
        "coulomb_friction_Nm": COULOMB,
        "viscous_friction_Nms": VISCOUS,
        "full_torque_speed_rad_s": FULL,
        "no_torque_speed_rad_s": NONE,
    }
    task = build_time_task(
        scenarios.from_mapping(
            {
                "name": "motors",
                "vehicle": {"use": "hypso1", "wheels": {} if ideal else motors},
                "initial": {
                    "attitude_deg": [0.0, 0.0, 0.0],
                    "wheel_speed_rad_s": [5.0, 8.0, -6.0, -7.0],
                },
                "target": {
                    "axis": [1.0, 0.5, -0.3],
                    "angle_deg": 50.0,
                    "rate_tolerance_rad_s": 1e-4,
                },
                "horizon": {"intervals": INTERVALS, "substeps": SUBSTEPS},
                "objective": {"kind": "minimum-time"},
            }
        )
    )
    return task, search_free_time(task, 4, 0)


def slope(craft, x, u):
    """Time derivative of q (4), omega (3) and wheel speeds (n), without external torques."""
    import casadi as ca

    q, w, s = x[:4], x[4:7], x[7:]
    wheels = craft.wheels
    axes, spin = ca.DM(np.asarray(wheels.axes)), ca.DM(np.asarray(wheels.inertia))
    inverse = ca.DM(np.linalg.inv(np.asarray(craft.inertia_without_spin)))
    momentum = ca.DM(np.asarray(craft.inertia)) @ w + axes @ (spin * s)
    turning = inverse @ (-axes @ u - ca.cross(w, momentum))
    rotating = 0.5 * ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w))
    return ca.vertcat(rotating, turning, u / spin - axes.T @ turning)


def ipopt_time(task, guess):
    """Least time of the same problem, with the motors' limits at both ends of every interval.

    guess : torques (N, n), step and states to start from.
    """
    import casadi as ca

    craft, n = task.craft, task.craft.wheels.count
    limit = np.asarray(craft.wheels.torque_limit)
    opti = ca.Opti()
    h = opti.variable()
    u, x = opti.variable(n, INTERVALS), opti.variable(7 + n, INTERVALS + 1)
    torques, step, states = guess
    for variable, value in ((u, torques.T), (h, step), (x, states.T)):
        opti.set_initial(variable, value)
    opti.subject_to(x[:, 0] == states[0])
    for k in range(INTERVALS):
        at, own = x[:, k], u[:, k]
        for _ in range(SUBSTEPS):
            d = h / SUBSTEPS
            k1 = slope(craft, at, own)
            k2 = slope(craft, at + d / 2 * k1, own)
            k3 = slope(craft, at + d / 2 * k2, own)
            k4 = slope(craft, at + d * k3, own)
            at = at + d / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        opti.subject_to(x[:, k + 1] == at)
        opti.subject_to(opti.bounded(-limit, own, limit))
        for s in (x[7:, k], x[7:, k + 1]):
            share = (own + COULOMB * ca.tanh(s / FRICTION_WIDTH) + VISCOUS * s) / limit
            for sense in (1.0, -1.0):
                falls = 1.0 - (sense * s - FULL) / (NONE - FULL)
                opti.subject_to(sense * share <= 1.0)
                opti.subject_to(sense * share <= falls)
    q = np.asarray(task.target.q_ob)
    opti.subject_to(x[1:4, -1] / x[0, -1] == q[1:] / q[0])
    opti.subject_to(x[4:7, -1] == 0.0)
    opti.minimize(INTERVALS * h)
    opti.solver("ipopt", {"ipopt.print_level": 0, "print_time": False, "ipopt.tol": 1e-9})
    return float(opti.solve().value(INTERVALS * h))


@pytest.mark.slow
def test_the_time_is_ipopts_and_longer_than_with_ideal_motors():
    pytest.importorskip("casadi")
    task, found = turned()
    assert found.reached[found.best]
    torque, step = found.controls[found.best], float(found.step[found.best])
    flown = task.fly(torque[None], np.array([step]))
    excess = motor_excess(task.craft.wheels, torque[None], flown.omega_bw)
    assert excess.max() <= 1e-6
    nodes = slice(None, None, task.nodes_between)
    states = np.concatenate(
        [np.asarray(part)[0, nodes] for part in (flown.q_ob, flown.omega_ib, flown.omega_bw)],
        axis=1,
    )
    time = INTERVALS * step
    least = ipopt_time(task, (torque, step, states))
    assert time == pytest.approx(least, rel=1e-4)
    ideal_task, ideal = turned(ideal=True)
    ideal_time = INTERVALS * float(ideal.step[ideal.best])
    assert time > 1.03 * ideal_time
    # The torques of ideal motors are beyond what these give.
    own = ideal.controls[ideal.best][None]
    speeds = ideal_task.fly(own, ideal.step[ideal.best][None], between=20).omega_bw
    assert motor_excess(task.craft.wheels, own, speeds).max() > 0.1
