"""Rows of an end that points one axis: their length, zeros and derivatives."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references import random_vehicles
from scipy.spatial.transform import Rotation

from jaxatt.attitude import quaternion
from jaxatt.attitude.free_roll import across
from jaxatt.problems.terminal_rows import attitude_row, attitude_rows, rolled_rate, swing_slope

SEEDS = range(4)


def drawn(seed, swing):
    """A reference, axes across a boresight, and an attitude off by a swing with a random roll."""
    rng = np.random.default_rng(seed)
    reference, axis = random_vehicles.unit(rng, 4), random_vehicles.unit(rng, 3)
    held = across(axis)
    way = rng.normal(size=2) @ held
    turn = Rotation.from_rotvec(swing * way / np.linalg.norm(way))
    roll = Rotation.from_rotvec(rng.uniform(-np.pi, np.pi) * axis)
    q = Rotation.from_quat(reference, scalar_first=True) * turn * roll
    return reference, held, q.as_quat(scalar_first=True)


@pytest.mark.parametrize("swing", [0.0, 1e-8, 1e-3, 1.0, 3.0, np.pi])
@pytest.mark.parametrize("seed", SEEDS)
def test_rows_are_four_sines_of_a_quarter_of_the_angle_at_any_roll(seed, swing):
    reference, held, q = drawn(seed, swing)
    for sign in (1.0, -1.0):
        rows = np.asarray(attitude_rows(reference, jnp.asarray(sign * q), jnp.asarray(held)))
        assert rows.shape == (2,)
        assert np.linalg.norm(rows) == pytest.approx(4.0 * np.sin(swing / 4.0), abs=2e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_three_held_axes_are_the_whole_attitude(seed):
    reference, _, q = drawn(seed, 1.0)
    whole = attitude_rows(jnp.asarray(reference), jnp.asarray(q), jnp.eye(3))
    np.testing.assert_array_equal(whole, attitude_row(jnp.asarray(reference), jnp.asarray(q)))
    rate = jnp.asarray([1.0, 2.0, 3.0])
    same = rolled_rate(jnp.asarray(reference), rate, jnp.asarray(q), jnp.eye(3))
    np.testing.assert_array_equal(same, rate)


def moved(reference, held, q):
    """Rows after a small turn about axes of the frame of reference."""

    def rows(turn):
        small = jnp.concatenate([jnp.ones(1), 0.5 * turn])
        after = quaternion.multiply(small / jnp.linalg.norm(small), q)
        return attitude_rows(reference, after, held)

    return jax.jacfwd(rows)(jnp.zeros(3))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_slope_is_exact_at_the_target_and_of_full_rank_everywhere(seed):
    for swing in (0.0, 0.5, 2.0, np.pi):
        reference, held, q = (jnp.asarray(x) for x in drawn(seed, swing))
        slope = np.asarray(swing_slope(reference, q, held))
        np.testing.assert_allclose(slope @ slope.T, np.eye(2), atol=1e-12)
        if swing == 0.0:
            np.testing.assert_allclose(slope, moved(reference, held, q), atol=1e-7)


@pytest.mark.parametrize("swing", [0.0, 1.0, 3.0, np.pi])
@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_are_finite_even_on_the_opposite_side(seed, swing):
    reference, held, q = (jnp.asarray(x) for x in drawn(seed, swing))
    assert np.isfinite(moved(reference, held, q)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_a_rate_turns_with_the_roll(seed):
    reference, held, q = (jnp.asarray(x) for x in drawn(seed, 0.0))
    rate = np.random.default_rng(seed).normal(size=3)
    found = rolled_rate(reference, jnp.asarray(rate), q, held)
    at = [Rotation.from_quat(np.asarray(x), scalar_first=True) for x in (reference, q)]
    np.testing.assert_allclose(at[1].apply(np.array(found)), at[0].apply(rate), atol=1e-12)
