"""Direction of the sun, and the fraction of its disk that the Earth hides."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp

from jaxatt.attitude.vectors import dot, norm

EARTH_RADIUS = 6378137.0
"""Equatorial radius [m], WGS 84."""

FIRST_YEAR, LAST_YEAR = 1950, 2050
"""Between them `sun_direction` is good to 0.01 deg."""

SUN_RADIUS = 6.957e8
ASTRONOMICAL_UNIT = 1.495978707e11


def sun_direction(days: jax.Array) -> jax.Array:
    """Unit vector (..., 3) from the Earth to the sun in inertial axes; `days` (...) since J2000.

    The low-precision formulas of the Astronomical Almanac, good to 0.01 deg from 1950 to 2050.
    """
    mean = jnp.deg2rad(280.460 + 0.9856474 * days)
    anomaly = jnp.deg2rad(357.528 + 0.9856003 * days)
    longitude = mean + jnp.deg2rad(1.915 * jnp.sin(anomaly) + 0.020 * jnp.sin(2.0 * anomaly))
    obliquity = jnp.deg2rad(23.439 - 4e-7 * days)
    across = jnp.sin(longitude)
    return jnp.stack(
        [jnp.cos(longitude), jnp.cos(obliquity) * across, jnp.sin(obliquity) * across], axis=-1
    )


def visible_fraction(r_i: jax.Array, sun: jax.Array) -> jax.Array:
    """Fraction (...) of the sun's disk that is not hidden by a spherical Earth.

    r_i : (..., 3) [m], position.  sun : (..., 3), unit vector to the sun.
    Source: Montenbruck and Gill (2000), *Satellite Orbits*, section 3.4.2.
    """
    to_sun = ASTRONOMICAL_UNIT * sun - r_i
    away, radius = norm(to_sun), norm(r_i)
    a, b = jnp.arcsin(SUN_RADIUS / away), jnp.arcsin(jnp.minimum(EARTH_RADIUS / radius, 1.0))
    c = jnp.arccos(jnp.clip(-dot(r_i, to_sun) / (radius * away), -1.0, 1.0))
    partly = (c > jnp.abs(a - b)) & (c < a + b)
    middle = jnp.where(partly, c, b)
    x = (middle**2 + a**2 - b**2) / (2.0 * middle)
    y = jnp.sqrt(jnp.maximum(a**2 - x**2, 0.0))
    hidden = (
        a**2 * jnp.arccos(jnp.clip(x / a, -1.0, 1.0))
        + b**2 * jnp.arccos(jnp.clip((middle - x) / b, -1.0, 1.0))
        - middle * y
    )
    free = 1.0 - hidden / (math.pi * a**2)
    return jnp.where(partly, free, jnp.where(c >= a + b, 1.0, 0.0))
