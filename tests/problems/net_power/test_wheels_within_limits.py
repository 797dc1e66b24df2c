"""Net power with wheels that are limited in speed and torque, and rub: beside CasADi and IPOPT."""

import dataclasses

import numpy as np
import pytest
from printed_cases import chapter_4

from jaxatt.optimize.status import Status
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.net_power.flight import fly
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.net_power.manoeuvre import WheelLimits
from jaxatt.problems.net_power.wheels.batch import SETTINGS, solve_starts
from jaxatt.problems.net_power.wheels.starts import draw_starts
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.problems.net_power.wheels.within_limits import keeping_to, within_limits
from jaxatt.problems.wheel_speeds import speed_excess
from jaxatt.spacecraft.speed_bands import speed_bands
from jaxatt.spacecraft.wheel_motor import FRICTION_WIDTH, wheel_motors

INTERVALS, SUBSTEPS = 24, 4
COULOMB, VISCOUS, FULL, NONE, FASTEST = 1e-4, 4e-6, 15.0, 90.0, 54.0


def with_wheels(manoeuvre, wheel_power="wheels", **changes):
    satellite = manoeuvre.satellite
    wheels = dataclasses.replace(satellite.craft.wheels, **changes)
    craft = dataclasses.replace(satellite.craft, wheels=wheels)
    satellite = dataclasses.replace(satellite, craft=craft, wheel_power=wheel_power)
    return dataclasses.replace(manoeuvre, satellite=satellite)


def spinning(manoeuvre, torque):
    """An answer that gives wheel 3 a torque [N m] and takes it back; the fake of a search."""
    held = np.zeros((1, manoeuvre.intervals, 3))
    held[0, :10, 2], held[0, 10:20, 2] = torque, -torque
    nothing = np.zeros(1)
    status = np.array([int(Status.CONVERGED)])
    return Solved(
        held, None, nothing, status, nothing, nothing, np.ones(1, int), limits=manoeuvre.limits
    )


@pytest.mark.parametrize("stay", [0.0, 1e-3])
def test_a_search_is_repeated_with_what_its_answer_breaks_and_only_then(stay):
    anywhere = dataclasses.replace(chapter_4(), end=None)
    asked = []

    def search(some):
        asked.append(some)
        return [spinning(one, 2e-3 if one.limits is None else 5e-5) for one in some]

    wide, banded = (
        with_wheels(anywhere, avoid=speed_bands([(low, low + 5.0, stay)], 3))
        for low in (900.0, 20.0)
    )
    (first,) = within_limits([wide], search)
    assert len(asked) == 1 and first.limits is None
    (second,) = within_limits([banded], search)
    assert len(asked) == 3 and asked[1][0].limits is None
    # Stricter than the limits are only after an answer with them broke them.
    assert isinstance(second.limits, WheelLimits) and not second.limits.slower.any()
    assert second.limits.every_band == (stay > 0.0)


def least_cost(task, torque, flown):
    """Least cost [J] of the same problem by IPOPT, effort included, from an answer."""
    import casadi as ca

    p, craft = task.parameters, task.manoeuvre.satellite.craft
    wheels, h, n = craft.wheels, task.manoeuvre.step, task.form.wheels
    limit, axes = np.asarray(wheels.torque_limit), ca.DM(np.asarray(wheels.axes))
    spin, inertia = ca.DM(np.asarray(wheels.inertia)), ca.DM(np.asarray(craft.inertia))
    inverse = ca.DM(np.asarray(p.inverse))
    normals, alpha = ca.DM(np.asarray(p.panels.normals).T), float(p.smoothing)
    area = ca.DM(np.asarray(p.panels.area) * np.asarray(p.panels.efficiency))

    def slope(x, u):
        q, w, s = x[:4], x[4:7], x[7:]
        turning = inverse @ (-axes @ u - ca.cross(w, inertia @ w + axes @ (spin * s)))
        rotating = 0.5 * ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w))
        return ca.vertcat(rotating, turning, u / spin - axes.T @ turning)

    def lit(q, sun):
        once = ca.cross(q[1:], sun)
        cosine = normals @ (sun - 2.0 * q[0] * once + 2.0 * ca.cross(q[1:], once))
        return ca.dot(area, 0.5 * (cosine + ca.sqrt(cosine**2 + alpha)) * cosine)

    opti = ca.Opti()
    u, x = opti.variable(n, INTERVALS), opti.variable(7 + n, INTERVALS + 1)
    m = opti.variable(2 * n, INTERVALS)
    states = np.concatenate([flown.q_ib[0], flown.omega_ib[0], flown.omega_bw[0]], axis=1)
    opti.set_initial(u, torque.T / limit[:, None])
    opti.set_initial(x, states.T)
    opti.set_initial(m, 0.2)
    opti.subject_to(x[:, 0] == states[0])
    cost = 0.0
    for k in range(INTERVALS):
        at, own = x[:, k], u[:, k] * limit
        for _ in range(SUBSTEPS):
            d = h / SUBSTEPS
            k1 = slope(at, own)
            k2 = slope(at + d / 2 * k1, own)
            k3 = slope(at + d / 2 * k2, own)
            k4 = slope(at + d * k3, own)
            at = at + d / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        opti.subject_to(x[:, k + 1] == at)
        opti.subject_to(opti.bounded(-1.0, u[:, k], 1.0))
        opti.subject_to(opti.bounded(-FASTEST, x[7:, k + 1], FASTEST))
        for end, s in enumerate((x[7:, k], x[7:, k + 1])):
            given = own + COULOMB * ca.tanh(s / FRICTION_WIDTH) + VISCOUS * s
            for sense in (1.0, -1.0):
                falls = 1.0 - (sense * s - FULL) / (NONE - FULL)
                opti.subject_to(sense * given / limit <= 1.0)
                opti.subject_to(sense * given / limit <= falls)
            power, magnitude = given * s, m[end * n : (end + 1) * n, k]
            opti.subject_to(magnitude >= float(p.taken) * power)
            opti.subject_to(magnitude >= -float(p.returned) * power)
            cost += 0.5 * h * ca.sum1(magnitude)
        sun, shone = np.asarray(p.stages.sun)[k], float(np.asarray(p.stages.shone)[k])
        cost += h * float(p.effort) * ca.sumsqr(u[:, k]) - shone * lit(x[:4, k], ca.DM(sun))
    q = np.asarray(p.reference)
    last = x[:4, -1]
    opti.subject_to(q[0] * last[1:] - last[0] * q[1:] - ca.cross(ca.DM(q[1:]), last[1:]) == 0.0)
    opti.subject_to(x[4:7, -1] == 0.0)
    opti.minimize(cost)
    opti.solver("ipopt", {"ipopt.print_level": 0, "print_time": False, "ipopt.tol": 1e-9})
    return float(opti.solve().value(cost))


@pytest.mark.slow
def test_net_energy_is_ipopts_where_speed_and_torque_bind():
    pytest.importorskip("casadi")
    given = dataclasses.replace(chapter_4(), intervals=INTERVALS, duration=30.0, substeps=1)
    motors = wheel_motors(3, COULOMB, VISCOUS, FULL, NONE)
    manoeuvre = with_wheels(given, motors=motors, speed_limit=np.full(3, FASTEST))
    task = wheels_task(keeping_to(manoeuvre))
    settings = dataclasses.replace(SETTINGS, tolerance=1e-9, max_iterations=150)
    solution = solve_starts([task], draw_starts(task, 4, 0), settings)
    converged = solution.status == int(Status.CONVERGED)
    assert converged.any()
    best = int(np.argmin(np.where(converged, solution.objective, np.inf)))
    wheels, limit = manoeuvre.satellite.craft.wheels, np.asarray(task.parameters.torque_limit)
    torque = np.asarray(solution.u)[best : best + 1, :INTERVALS, :3] * limit
    flown = fly(manoeuvre, torque)
    # It arrives, and both limits bind without being broken at the nodes.
    assert judge_flight(manoeuvre, flown).arrives[0]
    assert -1e-3 < speed_excess(wheels, flown.omega_bw).max() < 1e-6
    assert -1e-3 < motor_excess(wheels, torque, flown.omega_bw).max() < 1e-6
    cost = float(solution.objective[best] * task.parameters.energy_scale)
    assert cost == pytest.approx(least_cost(task, torque[0], flown), rel=1e-6)
