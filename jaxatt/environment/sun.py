"""Position and direction of the sun by date, and the fraction of its disk that is seen."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from jaxatt.attitude.vectors import matvec
from jaxatt.environment.occultation import disks
from jaxatt.environment.precession import precession

EARTH_RADIUS = 6378137.0
"""Equatorial radius [m], WGS 84."""

FIRST_YEAR, LAST_YEAR = 1950, 2050
"""Between them `sun_direction` is good to 0.01 deg."""

SUN_RADIUS = 6.957e8
ASTRONOMICAL_UNIT = 1.495978707e11


def sun_direction(days: jax.Array) -> jax.Array:
    """Unit vector (..., 3) from the Earth to the sun in inertial axes (J2000).

    days : (...), since J2000.
    The low-precision formulas of the Astronomical Almanac, good to 0.01 deg from 1950 to 2050,
    turned from the equinox of the date to the inertial one.
    """
    mean = jnp.deg2rad(280.460 + 0.9856474 * days)
    anomaly = _anomaly(days)
    longitude = mean + jnp.deg2rad(1.915 * jnp.sin(anomaly) + 0.020 * jnp.sin(2.0 * anomaly))
    obliquity = jnp.deg2rad(23.439 - 4e-7 * days)
    across = jnp.sin(longitude)
    of_date = jnp.stack(
        [jnp.cos(longitude), jnp.cos(obliquity) * across, jnp.sin(obliquity) * across], axis=-1
    )
    return matvec(jnp.swapaxes(precession(days), -1, -2), of_date)


def sun_position(days: jax.Array) -> jax.Array:
    """Position (..., 3) [m] of the sun in inertial axes (J2000), its distance within 0.01 %.

    days : (...), since J2000.  Source: the Astronomical Almanac.
    """
    anomaly = _anomaly(days)
    distance = 1.00014 - 0.01671 * jnp.cos(anomaly) - 0.00014 * jnp.cos(2.0 * anomaly)
    return (ASTRONOMICAL_UNIT * distance)[..., None] * sun_direction(days)


def visible_fraction(r_i: jax.Array, sun: jax.Array) -> jax.Array:
    """Fraction (...) of the sun's disk that is not hidden by a spherical Earth.

    r_i : (..., 3) [m], position.  sun : (..., 3), unit vector to the sun.
    """
    return disks(r_i, ASTRONOMICAL_UNIT * sun - r_i, EARTH_RADIUS, SUN_RADIUS).visible


def _anomaly(days: jax.Array) -> jax.Array:
    return jnp.deg2rad(357.528 + 0.9856003 * days)
