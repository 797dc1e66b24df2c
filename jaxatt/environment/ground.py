"""Places on the rotating Earth: positions, points below a satellite, and elevations."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import broadcast_batch, cross, dot, matvec, norm
from jaxatt.environment import precession
from jaxatt.environment.ellipsoid import EQUATORIAL_RADIUS, POLAR_RADIUS

_FLAT = (POLAR_RADIUS / EQUATORIAL_RADIUS) ** 2  # 1 - e^2 of the meridian


def earth_fixed(vector: ArrayLike, days: ArrayLike) -> jax.Array:
    """Components (..., 3) in Earth-fixed axes of an inertial vector; days (...) since J2000."""
    return matvec(precession.earth_fixed(jnp.asarray(days)), vector)


def vertical(latitude: ArrayLike, longitude: ArrayLike) -> jax.Array:
    """Unit vector (..., 3) upward at a geodetic latitude and longitude [rad], Earth-fixed."""
    cos = jnp.cos(jnp.asarray(latitude))
    up = (cos * jnp.cos(longitude), cos * jnp.sin(longitude), jnp.sin(latitude))
    return jnp.stack(jnp.broadcast_arrays(*up), axis=-1)


def place(latitude: ArrayLike, longitude: ArrayLike, height: ArrayLike = 0.0) -> jax.Array:
    """Position (..., 3) [m] at a height [m] on the WGS 84 ellipsoid, in Earth-fixed axes."""
    up, scale, height = broadcast_batch(
        vertical(latitude, longitude),
        jnp.asarray([1.0, 1.0, _FLAT]),
        jnp.asarray(height)[..., None],
    )
    across = EQUATORIAL_RADIUS / jnp.sqrt(jnp.sum(scale * up**2, axis=-1))
    return (across[..., None] * scale + height) * up


def elevation(
    position: ArrayLike, latitude: ArrayLike, longitude: ArrayLike, height: ArrayLike = 0.0
) -> jax.Array:
    """Angle (...) [rad] of a satellite above the horizon of a place; position Earth-fixed [m]."""
    position, at, up = broadcast_batch(
        position, place(latitude, longitude, height), vertical(latitude, longitude)
    )
    sight = position - at
    return jnp.arctan2(dot(sight, up), norm(cross(sight, up)))


def point_below(position: ArrayLike) -> tuple[jax.Array, jax.Array]:
    """Geodetic latitude and longitude (...) [rad] below an Earth-fixed position (..., 3) [m].

    Bowring's formula, good to 1e-9 rad in low orbits.
    """
    x, y, z = jnp.moveaxis(jnp.asarray(position), -1, 0)
    across = jnp.hypot(x, y)
    reduced = jnp.arctan2(z * EQUATORIAL_RADIUS, across * POLAR_RADIUS)
    beyond = (1.0 / _FLAT - 1.0) * POLAR_RADIUS
    latitude = jnp.arctan2(
        z + beyond * jnp.sin(reduced) ** 3,
        across - (1.0 - _FLAT) * EQUATORIAL_RADIUS * jnp.cos(reduced) ** 3,
    )
    return latitude, jnp.arctan2(y, x)
