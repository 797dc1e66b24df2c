"""Reorientations: their derivatives, MRP beside quaternions, and the flight by SciPy."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
from references import random_vehicles

from jaxatt.attitude import mrp, quaternion
from jaxatt.optimize.optimal_control import lagrangian_hessian, linearisation
from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.time_optimal.reorientation import ReorientationForm, reorientation
from jaxatt.problems.time_optimal.task import ReorientationTask, TimeGoal
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.simulation.free_body import BodyForm, FreeBody, step
from jaxatt.spacecraft import create, reaction_wheels, thrusters


def a_task(rng, wheels=4, pushed=False, spinning=False, **goal):
    axes = random_vehicles.wheel_axes(rng, wheels)
    craft = create(
        random_vehicles.inertia(rng),
        reaction_wheels(axes, 1e-4, 2e-3),
        thrusters=thrusters(np.concatenate([np.eye(3), -np.eye(3)], axis=1), 5e-3)
        if pushed
        else None,
    )
    q = random_vehicles.unit(rng, 4)
    initial_state = InitialState(
        np.array([1.0, 0.0, 0.0, 0.0]),
        np.zeros(3),
        100.0 * rng.normal(size=wheels) if spinning else np.zeros(wheels),
    )
    target = Target(q, np.zeros(3), 1e-4, 1e-6)
    return ReorientationTask(craft, initial_state, target, 12, TimeGoal(0.5, **goal))


CASES = {
    "at rest": {},
    "wheels turning": {"spinning": True},
    "thrusters": {"pushed": True},
}


@functools.partial(jax.jit, static_argnames=("program",), compiler_options=RUNS_ONCE)
def derivatives(program, x, u, x_next, args, costate):
    share = jnp.ones(())
    return (
        *linearisation(program, x, u, x_next, share, args)[:3],
        lagrangian_hessian(program, x, u, x_next, share, args, costate),
    )


@pytest.mark.parametrize(
    ("case", "limited"), [("at rest", False), ("wheels turning", True), ("thrusters", True)]
)
def test_closed_form_derivatives_are_those_of_the_step(case, limited):
    rng = np.random.default_rng(7)
    task = a_task(rng, **CASES[case])
    form = dataclasses.replace(task.form, speed_limited=limited)
    own = reorientation(form, task.actuation.size)
    plain = dataclasses.replace(own, linearisation=None, lagrangian_hessian=None)
    size = own.error_size + 1
    for _ in range(3):
        x = np.concatenate([random_vehicles.unit(rng, 4), 0.02 * rng.normal(size=size - 4)])
        x[-1] = np.log(rng.uniform(0.05, 0.25))
        u = rng.uniform(-1.0, 1.0, task.actuation.size)
        p = task.parameters
        ahead = own.dynamics(jnp.asarray(x), jnp.asarray(u), jnp.ones(()), p)
        x_next = own.retract(ahead, 0.01 * jnp.asarray(rng.normal(size=own.error_size)))
        costate = 10.0 * rng.normal(size=own.error_size)
        first = derivatives(own, x, u, x_next, p, costate)
        second = derivatives(plain, x, u, x_next, p, costate)
        for a, b in zip(first[:3], second[:3], strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-12)
        # The curvature is that of a coarser model: near where gaps and momentum are small.
        scale = np.abs(np.asarray(second[3])).max()
        np.testing.assert_allclose(
            first[3], second[3], atol=(0.08 if case == "at rest" else 0.25) * scale
        )


def flown(body, form, state, torque, h):
    def one(state, tau):
        end = step(state, tuple(tau), h, body, form)
        return end, jnp.stack(end)

    return jax.lax.scan(one, tuple(state), torque)[1]


@pytest.mark.parametrize("momentum", ["own", "carried"])
def test_mrp_and_quaternion_agree_with_scipy_through_a_whole_turn(momentum):
    rng = np.random.default_rng(11)
    inertia = random_vehicles.inertia(rng)
    body = FreeBody(jnp.asarray(inertia), jnp.asarray(np.linalg.inv(inertia)))
    torque = 0.02 * rng.normal(size=(40, 6))
    omega = np.array([0.9, -0.3, 0.5])  # so that MRP have to change sets
    h0 = inertia @ omega if momentum == "own" else 0.05 * rng.normal(size=3)
    if momentum == "own":
        torque[:, :3] = 0.0
    extra = [] if momentum == "own" else list(h0)

    def rate(k, y):
        q, w, h = y[:4], y[4:7], y[7:]
        total = -np.cross(w, h) + torque[k, 3:]
        spin = np.linalg.solve(inertia, total - torque[k, :3])
        qv = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([qv, spin, total])

    y, nodes = np.concatenate([[1.0, 0.0, 0.0, 0.0], omega, h0]), []
    for k in range(40):
        y = scipy.integrate.solve_ivp(
            lambda _, y, k=k: rate(k, y), (0.0, 0.3), y, rtol=1e-11, atol=1e-12
        ).y[:, -1]
        nodes.append(y)
    exact = np.array(nodes)
    found = {}
    for attitude in ("quaternion", "mrp"):
        form = BodyForm(attitude, "rk4", momentum, 40)
        begin = [1.0, 0.0, 0.0, 0.0] if attitude == "quaternion" else [0.0, 0.0, 0.0]
        state = [jnp.asarray(v) for v in (*begin, *omega, *extra)]
        found[attitude] = np.asarray(
            jax.jit(flown, static_argnums=1)(body, form, state, torque, 0.3)
        )
    turned = np.asarray(mrp.to_quaternion(found["mrp"][:, :3]))
    assert (np.linalg.norm(found["mrp"][:, :3], axis=1) <= 1.0 + 1e-12).all()
    for q, rates in (
        (found["quaternion"][:, :4], found["quaternion"][:, 4:]),
        (turned, found["mrp"][:, 3:]),
    ):
        alike = np.abs(np.sum(q * exact[:, :4], axis=1) / np.linalg.norm(exact[:, :4], axis=1))
        np.testing.assert_allclose(alike, 1.0, atol=1e-8)
        np.testing.assert_allclose(rates[:, :3], exact[:, 4:7], atol=1e-6)


def test_from_rest_with_wheels_the_momentum_stays_zero():
    """The form without momentum is the form that carries it, step by step, Euler included."""
    rng = np.random.default_rng(12)
    inertia = random_vehicles.inertia(rng)
    body = FreeBody(jnp.asarray(inertia), jnp.asarray(np.linalg.inv(inertia)))
    torque = np.concatenate([0.02 * rng.normal(size=(20, 3)), np.zeros((20, 3))], axis=1)
    for integration in ("euler", "rk4"):
        ends = []
        for momentum, extra in (("zero", []), ("carried", [0.0, 0.0, 0.0])):
            form = BodyForm("mrp", integration, momentum, 1)
            state = [jnp.asarray(v) for v in (*np.zeros(6), *extra)]
            ends.append(np.asarray(flown(body, form, state, jnp.asarray(torque), 0.5))[:, :6])
        np.testing.assert_allclose(ends[0], ends[1], rtol=1e-12, atol=1e-14)


def test_opposed_thrusters_are_one_control():
    task = a_task(np.random.default_rng(3), pushed=True)
    own = task.actuation
    assert own.size == 4 + 3
    rng = np.random.default_rng(4)
    u = rng.uniform(-1.0, 1.0, (5, own.size))
    torque = own.torques(u)
    assert (torque[:, 4:] >= 0.0).all()
    assert (torque[:, 4:7] * torque[:, 7:] == 0.0).all()
    pushed = torque[:, 4:] @ np.asarray(task.craft.thrusters.distribution).T
    np.testing.assert_allclose(pushed, u @ own.to_external.T, atol=1e-15)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_both_ways_round_end_at_the_target(sign):
    task = a_task(np.random.default_rng(5))
    relative = np.asarray(mrp.to_quaternion(task.turn(sign)))
    end = np.asarray(quaternion.multiply(np.asarray(task.initial_state.q_ob), relative))
    assert abs(end @ np.asarray(task.target.q_ob)) == pytest.approx(1.0, abs=1e-12)
    assert (np.linalg.norm(task.turn(sign)) <= 1.0) == (sign > 0.0)


def test_form_is_chosen_by_what_the_vehicle_does():
    rng = np.random.default_rng(6)
    assert a_task(rng).form.body.momentum == "zero"
    assert a_task(rng, spinning=True).form.body.momentum == "carried"
    assert isinstance(a_task(rng).form, ReorientationForm)
