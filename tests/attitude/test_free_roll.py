"""Attitudes with a free roll beside SciPy's rotations."""

import numpy as np
import pytest
from references import random_vehicles
from scipy.spatial.transform import Rotation

from jaxatt.attitude.free_roll import across, facing, nearest_roll, roll_angle, spread_rolls

SEEDS = range(5)


def drawn(seed):
    rng = np.random.default_rng(seed)
    unit = random_vehicles.unit
    return unit(rng, 4), unit(rng, 3), np.stack([unit(rng, 4) for _ in range(7)])


def rotation(q):
    return Rotation.from_quat(q, scalar_first=True)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_nearest_roll_points_as_the_reference_and_no_roll_is_nearer(seed):
    reference, axis, q = drawn(seed)
    found = rotation(nearest_roll(reference, axis, q))
    wanted = rotation(reference).apply(axis)
    np.testing.assert_allclose(found.apply(axis), np.tile(wanted, (7, 1)), atol=1e-14)
    angle = (found.inv() * rotation(q)).magnitude()
    off = np.arccos(np.clip(rotation(q).apply(axis) @ wanted, -1.0, 1.0))
    np.testing.assert_allclose(angle, off, atol=1e-7)
    rolls = rotation(reference) * Rotation.from_rotvec(
        np.linspace(0.0, 2.0 * np.pi, 100)[:, None] * axis
    )
    for one, least in zip(q, angle, strict=True):
        assert (rolls.inv() * rotation(one)).magnitude().min() >= least - 1e-12


@pytest.mark.parametrize("seed", SEEDS)
def test_a_rate_keeps_its_components_in_the_frame(seed):
    reference, axis, q = drawn(seed)
    rate = np.random.default_rng(seed).normal(size=3)
    rolled, turned = facing(reference, rate, axis, q)
    in_frame = rotation(rolled).apply(turned)
    np.testing.assert_allclose(in_frame, np.tile(rotation(reference).apply(rate), (7, 1)))
    np.testing.assert_allclose(facing(reference, axis, axis, q)[1], np.tile(axis, (7, 1)))


def test_rolls_of_starts_are_spread_evenly_and_depend_on_their_number_only():
    reference, axis, _ = drawn(11)
    many = spread_rolls(reference, axis, 64)
    np.testing.assert_array_equal(spread_rolls(reference, axis, 5), many[:5])
    np.testing.assert_allclose(many[0], reference)
    rolls = np.sort(np.mod(roll_angle(reference, axis, many), 2.0 * np.pi))
    gaps = np.diff(rolls, append=rolls[0] + 2.0 * np.pi)
    assert gaps.min() / (2.0 * np.pi / 64) > 0.4 and gaps.max() / (2.0 * np.pi / 64) < 2.0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_opposite_direction_is_no_special_case(seed):
    reference, axis, _ = drawn(seed)
    turn = Rotation.from_rotvec(np.pi * across(axis)[0])
    q = (rotation(reference) * turn).as_quat(scalar_first=True)
    found = nearest_roll(reference, axis, q)
    assert (rotation(found).inv() * rotation(q)).magnitude() == pytest.approx(np.pi)


@pytest.mark.parametrize("seed", SEEDS)
def test_two_axes_across_complete_a_frame(seed):
    _, axis, _ = drawn(seed)
    first, second = across(axis)
    np.testing.assert_allclose(np.cross(first, second), axis, atol=1e-15)
    assert first @ second == pytest.approx(0.0, abs=1e-15)
