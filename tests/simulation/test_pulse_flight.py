"""Flights with exact switching against an adaptive integrator that stops at every switch."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jaxatt.environment.table import Surroundings, refined, tabulate
from jaxatt.simulation.flight import at_nodes, fly_torque
from jaxatt.simulation.pulse_flight import fly_pulses
from jaxatt.simulation.pulses import anchors, overlaps, partly_open, place, split
from jaxatt.spacecraft import create, reaction_wheels, thrusters
from jaxatt.spacecraft.dynamics import AttitudeState

STEP, COUNT, COAST = 0.7, 6, 2
STILL = Surroundings(None, jnp.asarray(0.0), jnp.asarray(0.0), jnp.asarray(1.0))
TABLE = tabulate(STILL, 0.0, STEP, COUNT + COAST, 20)
_fly = jax.jit(fly_pulses)


def mixed_craft(rng: np.random.Generator):
    """Wheels and tilted thrusters on one body."""
    root = rng.normal(size=(3, 3))
    inertia = np.eye(3) * 2.0 + 0.1 * (root + root.T)
    wheels = reaction_wheels(np.eye(3), 1e-2, 0.05)
    return create(inertia, wheels, "mixed", thrusters(rng.normal(size=(3, 4)), 0.3))


def by_scipy(craft, q, omega, speeds, wheel, pulses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Newton and Euler written anew, integrated from switch to switch."""
    axes, spin = np.asarray(craft.wheels.axes), np.asarray(craft.wheels.inertia)
    inertia, b = np.asarray(craft.inertia), np.asarray(craft.thrusters.distribution)
    inner = np.linalg.inv(inertia - axes @ np.diag(spin) @ axes.T)
    state, limit = np.concatenate([q, omega, speeds]), np.asarray(craft.thrusters.torque_limit)
    for k in range(COUNT + COAST):
        row = wheel[k] if k < COUNT else np.zeros(3)
        opens = pulses.opens[k] if k < COUNT else np.zeros(4)
        shuts = pulses.shuts[k] if k < COUNT else np.zeros(4)
        edges = np.unique(np.concatenate([[0.0, STEP], opens, shuts]))
        for begin, end in itertools.pairwise(edges):
            middle = 0.5 * (begin + end)
            push = b @ np.where((opens <= middle) & (middle < shuts), limit, 0.0)

            def rate(_, x, push=push, row=row):
                w, s = x[4:7], x[7:]
                total = inertia @ w + axes @ (spin * s)
                turn = inner @ (push - axes @ row - np.cross(w, total))
                matrix = np.array(
                    [
                        [0, -w[0], -w[1], -w[2]],
                        [w[0], 0, w[2], -w[1]],
                        [w[1], -w[2], 0, w[0]],
                        [w[2], w[1], -w[0], 0],
                    ]
                )
                return np.concatenate([0.5 * matrix @ x[:4], turn, row / spin - axes.T @ turn])

            state = solve_ivp(rate, (begin, end), state, rtol=1e-11, atol=1e-12).y[:, -1]
    return state[:4] / np.linalg.norm(state[:4]), state[4:7], state[7:]


@pytest.mark.parametrize("seed", range(3))
def test_flight_agrees_with_an_adaptive_integrator(seed: int) -> None:
    rng = np.random.default_rng(seed)
    craft = mixed_craft(rng)
    opens = rng.uniform(0.0, STEP, (COUNT, 4))
    shuts = np.maximum(opens, rng.uniform(0.0, STEP, (COUNT, 4)))
    duty = (shuts - opens) / STEP
    pulses = place(duty, rng.uniform(size=duty.shape), rng.uniform(-0.05, 0.05, (COUNT, 3)), STEP)
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    omega, speeds = 0.2 * rng.normal(size=3), rng.normal(size=3)
    flown = _fly(
        craft,
        AttitudeState(jnp.asarray(q), jnp.asarray(omega), jnp.asarray(speeds)),
        jnp.asarray(pulses.wheel_torque),
        jnp.asarray(pulses.opens),
        jnp.asarray(pulses.shuts),
        TABLE,
    )
    wanted = by_scipy(craft, q, omega, speeds, pulses.wheel_torque, pulses)
    np.testing.assert_allclose(np.abs(wanted[0] @ np.asarray(flown.q_ob[-1])), 1.0, atol=1e-12)
    np.testing.assert_allclose(flown.omega_ib[-1], wanted[1], atol=1e-8)
    np.testing.assert_allclose(flown.omega_bw[-1], wanted[2], atol=1e-6)
    np.testing.assert_allclose(flown.thrust[:COUNT], duty * 0.3, atol=1e-12)


def test_whole_openings_fly_as_constant_torque_does() -> None:
    rng = np.random.default_rng(9)
    craft = mixed_craft(rng)
    duty = (rng.uniform(size=(COUNT, 4)) < 0.5).astype(float)
    pulses = place(duty, anchors(duty), np.zeros((COUNT, 3)), STEP)
    start = AttitudeState(jnp.array([1.0, 0, 0, 0]), jnp.zeros(3), jnp.zeros(3))
    opens, shuts = jnp.asarray(pulses.opens), jnp.asarray(pulses.shuts)
    valves = _fly(craft, start, jnp.zeros((COUNT, 3)), opens, shuts, TABLE)
    torque = jnp.asarray(np.concatenate([np.zeros((COUNT, 3)), 0.3 * duty], axis=1))
    constant = jax.jit(fly_torque)(craft, start, torque, TABLE)
    np.testing.assert_allclose(valves.q_ob, constant.q_ob, atol=1e-11)
    np.testing.assert_allclose(valves.thrust, constant.thrust, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_openings_keep_their_width_and_stay_inside(seed: int) -> None:
    rng = np.random.default_rng(seed)
    duty = np.clip(rng.uniform(-0.5, 1.5, (20, 3)), 0.0, 1.0)
    pulses = place(duty, anchors(duty), np.zeros((20, 0)), STEP)
    np.testing.assert_allclose(pulses.on_time, duty * STEP, atol=1e-15)
    assert (pulses.opens >= 0.0).all() and (pulses.shuts <= STEP + 1e-15).all()
    limit = np.array([0.1, 0.2, 0.3])
    _, sampled = pulses.thrust(limit)
    assert partly_open(sampled, limit) == 0
    assert partly_open(duty * limit, limit) == int(((duty > 0) & (duty < 1)).sum())
    whole = duty >= 1.0
    follows = whole[:-1] & (duty[1:] > 0.0)
    assert (pulses.opens[1:][follows] == 0.0).all()


def test_overlaps_are_counted_by_interval() -> None:
    duty = np.array([[1.0, 0.5], [0.5, 0.0], [0.0, 1.0]])
    pulses = place(duty, np.array([[0.0, 1.0], [0.0, 0.0], [0.0, 0.0]]), np.zeros((3, 0)), STEP)
    assert overlaps(pulses, ((0, 1),)) == 1


def test_a_flight_cut_finer_switches_at_the_same_instants():
    rng = np.random.default_rng(12)
    craft = mixed_craft(rng)
    duty = rng.uniform(size=(COUNT, 4)) * (rng.uniform(size=(COUNT, 4)) < 0.7)
    pulses = place(duty, anchors(duty), 0.02 * rng.normal(size=(COUNT, 3)), STEP)
    q = rng.normal(size=4)
    start = AttitudeState(*map(jnp.asarray, (q / np.linalg.norm(q), np.zeros(3), np.zeros(3))))
    whole = _fly(craft, start, pulses.wheel_torque, pulses.opens, pulses.shuts, TABLE)
    cut = split(pulses, 20)
    np.testing.assert_allclose(cut.on_time.reshape(COUNT, 20, 4).sum(axis=1), pulses.on_time)
    fine = jax.jit(fly_pulses, static_argnums=6)(
        craft, start, cut.wheel_torque, cut.opens, cut.shuts, refined(TABLE), 1
    )
    sampled = at_nodes(fine, 20)
    for name in ("q_ob", "omega_ib", "omega_bw", "thrust", "wheel_torque"):
        np.testing.assert_allclose(getattr(sampled, name), getattr(whole, name), atol=1e-9)
    assert sampled.fine is fine and fine.q_ob.shape[0] == 20 * (COUNT + COAST) + 1
