"""The PD law of the source: stable as meant, within limits, and unstable where it is said to be."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references import wheeled_body

from jaxatt import scenarios
from jaxatt.control.pd import PDLaw
from jaxatt.environment.table import tabulate
from jaxatt.problems.surroundings import surroundings_of
from jaxatt.simulation.flight import fly, fly_torque
from jaxatt.spacecraft.dynamics import at_relative_rate

STEP, INTERVALS = 1.0, 150
LIMIT = 3e-3


@pytest.fixture(scope="module")
def scenario():
    return scenarios.load("hypso1-90-45-15-perturbed")


@pytest.fixture(scope="module")
def flights(scenario):
    """Clipped flights (S) to random references, the last three a half turn away, and the law's."""
    rng = np.random.default_rng(5)
    starts = rng.normal(size=(8, 4))
    starts /= np.linalg.norm(starts, axis=1, keepdims=True)
    references = rng.normal(size=(8, 4))
    references /= np.linalg.norm(references, axis=1, keepdims=True)
    axes = rng.normal(size=(3, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    for row, axis in zip((5, 6, 7), axes, strict=True):
        references[row] = _product(starts[row], np.concatenate([[0.0], axis]))
    craft = scenario.vehicle
    table = tabulate(surroundings_of(scenario), 0.0, STEP, INTERVALS, 20)
    first = jax.tree.map(lambda leaf: leaf[0], table.nodes)
    rates = 0.01 * rng.normal(size=(8, 3))

    def one(q, rate, reference):
        start = at_relative_rate(q, rate, jnp.zeros(4), first)
        return fly(craft, start, PDLaw(craft, reference, jnp.zeros(3)), table)

    flown = jax.jit(jax.vmap(one))(*map(jnp.asarray, (starts, rates, references)))
    return references, jax.tree.map(np.asarray, flown)


def _product(a, b):
    return np.concatenate(
        [[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])]
    )


def test_it_brings_any_attitude_to_the_target_and_to_rest(flights):
    references, flown = flights
    begun = [
        wheeled_body.angle_between(q[0], r) for q, r in zip(flown.q_ob, references, strict=True)
    ]
    np.testing.assert_allclose(begun[5:], np.pi, atol=1e-6)
    assert min(begun) > 0.3
    ended = [
        wheeled_body.angle_between(q[-1], r) for q, r in zip(flown.q_ob, references, strict=True)
    ]
    # The sine of 1e-4 N m is not known to the law: its reach is amplitude / (J kp / 2).
    assert max(ended) < np.deg2rad(0.3)
    assert np.linalg.norm(flown.omega_ob[:, -1], axis=-1).max() < 3e-3


def test_every_wheel_stays_within_its_limit_and_the_limit_binds(flights):
    _, flown = flights
    size = np.abs(flown.wheel_torque)
    assert size.max() <= LIMIT * (1 + 1e-12)
    assert (size.max(axis=(1, 2)) > 0.999 * LIMIT).all()


def test_torque_by_hand(scenario):
    craft = scenario.vehicle
    rng = np.random.default_rng(6)
    q, reference = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 4)))
    relative = rng.normal(size=3)
    orbit_rate = jnp.asarray([0.0, -1e-3, 0.0])
    table = tabulate(surroundings_of(scenario), 0.0, STEP, 1, 1)
    environment = jax.tree.map(lambda leaf: leaf[0], table.nodes)._replace(orbit_rate=orbit_rate)
    state = at_relative_rate(jnp.asarray(q), jnp.asarray(relative), jnp.zeros(4), environment)
    conjugate = reference * np.array([1.0, -1.0, -1.0, -1.0])
    error = _product(conjugate, q)
    error = error * np.sign(error[0])
    spin = np.asarray(craft.wheels.axes) * np.asarray(craft.wheels.inertia)
    inertia = np.asarray(craft.inertia) - spin @ np.asarray(craft.wheels.axes).T
    body = inertia @ (2.7 * relative + 3.0 * error[1:])
    expected = np.linalg.pinv(np.asarray(craft.wheels.axes)) @ body
    for sign in (1.0, -1.0):  # q_ref and -q_ref are one attitude
        law = PDLaw(craft, jnp.asarray(sign * reference), jnp.zeros(3), clipped=False)
        np.testing.assert_allclose(law(jnp.asarray(0), state, environment), expected, rtol=1e-10)
    clipped = PDLaw(craft, jnp.asarray(reference), jnp.zeros(3))
    np.testing.assert_allclose(
        clipped(jnp.asarray(0), state, environment), np.clip(expected, -LIMIT, LIMIT), rtol=1e-10
    )


@pytest.mark.parametrize(("hold", "stable"), [(1.4, False), (0.2, True)])
def test_sampled_and_held_it_is_stable_only_when_sampled_fast(scenario, hold, stable):
    # Derivative gain times hold, 2.7 x 1.4, exceeds 2.
    craft = scenario.vehicle
    surroundings = surroundings_of(scenarios.load("hypso1-90-45-15"))
    table = tabulate(surroundings, 0.0, hold, 1, 4)
    first = jax.tree.map(lambda leaf: leaf[0], table.nodes)
    law = PDLaw(craft, jnp.asarray([1.0, 0, 0, 0]), jnp.zeros(3), clipped=False)
    small = jnp.asarray([1.0, 1e-4, -1e-4, 2e-4])
    start = at_relative_rate(small / jnp.linalg.norm(small), jnp.zeros(3), jnp.zeros(4), first)

    @jax.jit
    def held(state):
        torque = law(jnp.asarray(0), state, first)
        flight = fly_torque(craft, state, torque[None], table)
        end = type(state)(flight.q_ob[-1], flight.omega_ib[-1], flight.omega_bw[-1])
        return end, jnp.linalg.norm(flight.omega_ob[-1])

    sizes = []
    state = start
    for _ in range(100 if stable else 5):
        state, rate = held(state)
        sizes.append(float(rate))
    if stable:
        assert sizes[-1] < 1e-6
        assert wheeled_body.angle_between(state.q_ob, [1.0, 0, 0, 0]) < 1e-6
    else:
        assert sizes[-1] > 50.0 * sizes[0]
