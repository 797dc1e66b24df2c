"""Rigid body and wheels: mappings, momentum and every refusal."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.scenarios import load_vehicle
from jaxatt.spacecraft import (
    FieldError,
    Spacecraft,
    create,
    momentum,
    reaction_wheels,
    total_momentum,
)

INERTIA = np.array([[0.0775, 0.0002, -0.0002], [0.0002, 0.1067, 0.0005], [-0.0002, 0.0005, 0.0389]])
SKEW = 1.0 / np.sqrt(3.0)
AXES = np.hstack([np.eye(3), np.full((3, 1), SKEW)])


def wheels(**changes):
    return reaction_wheels(**{"axes": AXES, "inertia": 2.1e-4, "torque_limit": 3e-3, **changes})


@pytest.fixture(params=[3, 4, 6])
def random_craft(request):
    rng = np.random.default_rng(request.param)
    axes = rng.normal(size=(3, request.param))
    count = request.param
    built = reaction_wheels(axes, rng.uniform(1e-4, 3e-4, count), rng.uniform(1e-3, 4e-3, count))
    return create(INERTIA, built)


def test_allocation_is_the_moore_penrose_inverse(random_craft):
    expected = np.linalg.pinv(random_craft.wheels.axes)
    np.testing.assert_allclose(random_craft.wheels.allocation, expected, atol=1e-12)


def test_allocation_of_hypso1_by_hand():
    # A = [I | a], a of unit length: A A' = I + a a', so A+ = [I - a a'/2 ; a'/2].
    a = np.full((3, 1), SKEW)
    expected = np.vstack([np.eye(3) - a @ a.T / 2.0, a.T / 2.0])
    np.testing.assert_allclose(wheels().allocation, expected, atol=1e-15)


def test_inertia_without_spin(random_craft):
    axes, spin = random_craft.wheels.axes, random_craft.wheels.inertia
    expected = INERTIA - sum(
        spin[i] * np.outer(axes[:, i], axes[:, i]) for i in range(random_craft.wheels.count)
    )
    np.testing.assert_allclose(random_craft.inertia_without_spin, expected, atol=1e-16)


@pytest.mark.parametrize("batch", [(), (5,), (2, 3)])
def test_total_momentum_over_batches(random_craft, batch):
    rng = np.random.default_rng(0)
    rate = rng.normal(size=(*batch, 3))
    speed = rng.normal(size=(*batch, random_craft.wheels.count))
    spin = random_craft.wheels.axes * random_craft.wheels.inertia
    np.testing.assert_allclose(momentum(random_craft.wheels, speed), speed @ spin.T, rtol=1e-12)
    np.testing.assert_allclose(
        total_momentum(random_craft, rate, speed), rate @ INERTIA.T + speed @ spin.T, rtol=1e-10
    )


def test_pytree_keeps_the_name_and_is_traced_by_value():
    traces = []

    @jax.jit
    def kinetic(craft: Spacecraft):
        traces.append(craft.name)
        return jnp.trace(craft.inertia_without_spin)

    craft = load_vehicle("hypso1")
    heavier = dataclasses.replace(craft, inertia=craft.inertia * 1.1)
    assert kinetic(heavier) > kinetic(craft)
    assert traces == ["hypso1"]
    assert jax.tree.map(lambda leaf: leaf, craft).name == "hypso1"


def test_allocation_and_inertia_over_a_batch_of_vehicles():
    craft = load_vehicle("hypso1")
    batch = jax.tree.map(lambda leaf: jnp.stack([leaf, 2.0 * leaf]), craft)
    each = jax.vmap(lambda c: (c.wheels.allocation, c.inertia_without_spin))(batch)
    np.testing.assert_allclose(batch.wheels.allocation, each[0], atol=1e-14)
    np.testing.assert_allclose(batch.inertia_without_spin, each[1], atol=1e-14)


def test_allocation_has_a_gradient_at_equal_singular_values():
    def effort(axes):
        built = dataclasses.replace(wheels(axes=np.eye(3)), axes=axes)
        return jnp.sum(built.allocation**2)

    gradient = jax.grad(effort)(jnp.eye(3))
    np.testing.assert_allclose(gradient, -2.0 * np.eye(3), atol=1e-12)


def test_hypso1_is_the_printed_vehicle():
    craft = load_vehicle("hypso1")
    np.testing.assert_array_equal(craft.inertia, INERTIA)
    np.testing.assert_allclose(craft.wheels.axes, AXES, atol=1e-15)
    np.testing.assert_array_equal(craft.wheels.inertia, np.full(4, 2.1e-4))
    np.testing.assert_array_equal(craft.wheels.torque_limit, np.full(4, 3e-3))
    assert np.isinf(craft.wheels.speed_limit).all()


def test_long_axes_are_scaled_with_a_note():
    notes: list[str] = []
    built = wheels(axes=np.diag([1.0, 2.0, 1.0]), notes=notes)
    np.testing.assert_array_equal(built.axes, np.eye(3))
    assert notes == ["wheel axis 2 was scaled to unit length; its length was 2"]


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"axes": np.ones((4, 3))}, ["axes", "(4, 3)", "(3, n)"]),
        ({"axes": [[1, 0], [0, 1], [0, 0]]}, ["span 2", "(0, 0, 1)", "add or tilt a wheel"]),
        ({"axes": [[1, 2, 3], [0, 0, 0], [0, 0, 0]]}, ["span 1"]),
        ({"axes": np.diag([1.0, 1.0, 0.0])}, ["wheel 3", "(0, 0, 0)"]),
        ({"axes": np.diag([1.0, 1.0, np.nan])}, ["axes", "finite"]),
        ({"axes": "xyz"}, ["axes", "is a text", "without quotes"]),
        ({"axes": [[1, 0, 0], [0, 1], [0, 0, 1]]}, ["axes", "equal length"]),
        ({"inertia": 0.0}, ["inertia", "greater than 0"]),
        ({"inertia": [1e-4, 1e-4, -1e-4, 1e-4]}, ["inertia", "-0.0001"]),
        ({"inertia": [1e-4, 1e-4]}, ["inertia", "there are 4 wheels"]),
        ({"torque_limit": -3e-3}, ["torque_limit", "-0.003", "greater than 0"]),
        ({"torque_limit": np.inf}, ["torque_limit", "finite"]),
        ({"torque_limit": True}, ["torque_limit", "True"]),
        ({"torque_limit": [True, 0.1, 0.1, 0.1]}, ["torque_limit", "real numbers"]),
        ({"speed_limit": -1.0}, ["speed_limit", "greater than 0"]),
        ({"speed_limit": np.nan}, ["speed_limit", "nan"]),
    ],
)
def test_wheels_that_are_refused(change, parts):
    with pytest.raises(FieldError) as caught:
        wheels(**change)
    assert isinstance(caught.value, ValueError)
    for part in parts:
        assert part in str(caught.value)


@pytest.mark.parametrize(
    ("inertia", "parts"),
    [
        (np.eye(2), ["(2, 2)", "three rows"]),
        (np.diag([0.1, np.nan, 0.1]), ["finite"]),
        (np.diag([0.1, 0.1, 0.1]) + np.eye(3, k=1) * 1e-3, ["not symmetric", "row 1, column 2"]),
        (np.diag([0.1, -0.1, 0.1]), ["positive definite", "-0.1"]),
        (np.zeros((3, 3)), ["positive definite"]),
        (np.diag([0.1, 0.1, 0.3]), ["triangle inequality", "0.3"]),
        (np.diag([1e-4, 1e-4, 1e-4]), ["wheels' own inertia"]),
    ],
)
def test_inertias_that_are_refused(inertia, parts):
    with pytest.raises(FieldError, match="inertia") as caught:
        create(inertia, wheels())
    for part in parts:
        assert part in str(caught.value)


def test_a_flat_plate_is_allowed():
    assert create(np.diag([0.1, 0.1, 0.2]), wheels()).name == "spacecraft"
