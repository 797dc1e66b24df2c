"""Places on the ground: against published positions, and against each other."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.environment import ground
from jaxatt.environment.ellipsoid import ground_point


def test_position_of_a_published_place():
    """Wettzell, IERS station 7224: ITRF position, from its geodetic coordinates at height zero."""
    latitude, longitude = np.deg2rad([49.1450031, 12.8774506])
    height = 669.121
    position = ground.place(latitude, longitude) + height * ground.vertical(latitude, longitude)
    np.testing.assert_allclose(position, [4075539.9, 931735.3, 4801629.4], atol=30.0)


def test_the_point_below_is_below():
    key = jax.random.key(3)
    latitude = jax.random.uniform(key, (200,), minval=-1.57, maxval=1.57)
    longitude = jax.random.uniform(jax.random.key(4), (200,), minval=-3.14, maxval=3.14)
    position = ground.place(latitude, longitude) + 550e3 * ground.vertical(latitude, longitude)
    found = ground.point_below(position)
    np.testing.assert_allclose(found[0], latitude, atol=1e-8)
    np.testing.assert_allclose(found[1], longitude, atol=1e-12)
    np.testing.assert_allclose(
        ground.elevation(position, latitude, longitude), np.pi / 2, atol=1e-6
    )


def test_the_horizon_is_where_the_line_of_sight_grazes():
    """A satellite whose elevation is positive sees the place, one below the horizon does not."""
    place = ground.place(0.7, 0.2)
    for tilt, seen in ((0.02, True), (-0.02, False)):
        up = ground.vertical(0.7, 0.2)
        across = jnp.cross(up, jnp.array([0.0, 0.0, 1.0]))
        across = across / jnp.linalg.norm(across)
        satellite = place + 2.5e6 * (jnp.cos(tilt) * across + jnp.sin(tilt) * up)
        assert float(ground.elevation(satellite, 0.7, 0.2)) == pytest.approx(tilt, abs=1e-12)
        hit = ground_point(satellite, place - satellite)
        assert (float(jnp.linalg.norm(hit - place)) < 1.0) is seen


def test_earth_fixed_axes_turn_once_a_sidereal_day():
    days = jnp.array([8000.0, 8000.0 + 0.99726966])
    r = jnp.tile(jnp.array([7e6, 1e6, 2e6]), (2, 1))
    first, second = ground.earth_fixed(r, days)
    np.testing.assert_allclose(first, second, atol=60.0)
