"""Margins of pointing limits against plain NumPy, and their gradients."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxatt.problems.pointing.cones import (
    PointingLimits,
    cone_angles,
    cone_margin,
    pointing_margins,
)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def drawn(seed, count=4, rates=True):
    """Random attitudes (9, 4), rates, directions and limits, with the plain half angles."""
    rng = np.random.default_rng(seed)
    q = unit(rng.normal(size=(9, 4)))
    q[0] = [0.0, 1.0, 0.0, 0.0]  # half a turn
    q[1] = unit(np.array([1.0, 1e-9, -1e-9, 0.0]))
    half = rng.uniform(0.05, 3.0, count)
    limits = PointingLimits(
        jnp.asarray(unit(rng.normal(size=(count, 3)))),
        jnp.cos(half),
        jnp.asarray(np.where(rng.uniform(size=count) < 0.5, -1.0, 1.0)),
        jnp.asarray(rng.uniform(0.1, 2.0, 3 if rates else 0)),
    )
    return q, rng.normal(size=(9, 3)), unit(rng.normal(size=(9, count, 3))), half, limits


def plain_angles(q, directions, boresights):
    """(9, m) by SciPy's rotations."""
    turned = np.stack([Rotation.from_quat(row[[1, 2, 3, 0]]).apply(boresights) for row in q])
    return np.arccos(np.clip(np.sum(turned * directions, axis=-1), -1.0, 1.0))


@pytest.mark.parametrize("rates", [True, False])
def test_margins_are_those_of_plain_rotations(rates):
    q, omega, directions, half, limits = drawn(3, rates=rates)
    found = jax.vmap(pointing_margins, in_axes=(0, 0, 0, None))(q, omega, directions, limits)
    angle = plain_angles(q, directions, np.array(limits.boresights))
    chord, border = (np.sqrt(4.0 * np.sin(a / 2.0) ** 2 + 0.02**2) for a in (angle, half))
    cones = np.asarray(limits.senses) * (border - chord) * border / np.sin(half)
    expected = [cones]
    if rates:
        relative = omega / np.asarray(limits.rate_limit)
        expected += [1.0 - relative, 1.0 + relative]
    assert found.shape == (9, limits.rows)
    np.testing.assert_allclose(found, np.concatenate(expected, axis=1), atol=1e-13)


def test_a_margin_is_negative_exactly_where_a_limit_is_broken():
    q, omega, directions, half, limits = drawn(11)
    found = jax.vmap(pointing_margins, in_axes=(0, 0, 0, None))(q, omega, directions, limits)
    angle = plain_angles(q, directions, np.array(limits.boresights))
    inside = angle <= half
    satisfied = np.where(np.asarray(limits.senses) > 0, inside, ~inside)
    np.testing.assert_array_equal(np.asarray(found[:, : limits.count]) >= 0.0, satisfied)
    slow = np.abs(omega) <= np.asarray(limits.rate_limit)
    np.testing.assert_array_equal(
        (np.asarray(found[:, limits.count :]).reshape(9, 2, 3) >= 0).all(axis=1), slow
    )


def test_angles_are_accurate_at_both_ends():
    q = jnp.array([1.0, 0.0, 0.0, 0.0])
    tiny = 1e-9
    directions = jnp.array([[np.cos(tiny), np.sin(tiny), 0.0], [-np.cos(tiny), np.sin(tiny), 0.0]])
    boresights = jnp.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    angles = cone_angles(q, directions, boresights)
    np.testing.assert_allclose(angles, [tiny, np.pi - tiny], rtol=1e-12)
    rng = np.random.default_rng(5)
    q, directions = unit(rng.normal(size=(9, 4))), unit(rng.normal(size=(9, 2, 3)))
    found = cone_angles(jnp.asarray(q), jnp.asarray(directions), boresights)
    np.testing.assert_allclose(found, plain_angles(q, directions, np.array(boresights)), atol=1e-12)


def test_the_gradient_is_finite_even_in_the_middle_of_a_cone():
    limits = PointingLimits(
        jnp.array([[0.0, 0.0, 1.0]] * 2),
        jnp.cos(jnp.array([0.4, 0.4])),
        jnp.array([1.0, -1.0]),
        jnp.zeros(0),
    )
    directions = jnp.array([[0.0, 0.0, 1.0]] * 2)
    at = jnp.array([1.0, 0.0, 0.0, 0.0])
    slope = jax.jacobian(pointing_margins)(at, jnp.zeros(3), directions, limits)
    assert jnp.isfinite(slope).all()


def test_a_margin_is_the_angle_left_near_the_cone():
    rng = np.random.default_rng(8)
    half = rng.uniform(0.01, 3.1, 20)
    for sense in (-1.0, 1.0):
        near = cone_margin(np.cos(half + sense * 1e-5), np.cos(half), -sense)
        np.testing.assert_allclose(near, np.full(20, 1e-5), rtol=5e-3)
