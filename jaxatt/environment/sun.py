"""Position and direction of the sun by date, and the fraction of its disk that is seen."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from jaxatt.attitude.vectors import matvec
from jaxatt.environment.earth_orbit import apparent_longitude, sun_distance
from jaxatt.environment.epoch import terrestrial
from jaxatt.environment.nutation import mean_obliquity
from jaxatt.environment.occultation import disks
from jaxatt.environment.precession import precession

EARTH_RADIUS = 6378137.0
"""Equatorial radius [m], WGS 84."""

FIRST_YEAR, LAST_YEAR = 1950, 2050
"""Between them `sun_direction` is good to 0.001 deg."""

SUN_RADIUS = 6.957e8
ASTRONOMICAL_UNIT = 1.495978707e11


def sun_direction(days: jax.Array) -> jax.Array:
    """Unit vector (..., 3) in inertial axes (J2000) along which the sun is seen from the Earth.

    days : (...), since J2000.
    """
    moment = terrestrial(days)
    longitude, obliquity = apparent_longitude(moment), mean_obliquity(moment)
    across = jnp.sin(longitude)
    of_date = jnp.stack(
        [jnp.cos(longitude), jnp.cos(obliquity) * across, jnp.sin(obliquity) * across], axis=-1
    )
    return matvec(jnp.swapaxes(precession(moment), -1, -2), of_date)


def sun_position(days: jax.Array) -> jax.Array:
    """Position (..., 3) [m] of the sun in inertial axes (J2000), its distance within 2e-5.

    days : (...), since J2000.
    """
    distance = ASTRONOMICAL_UNIT * sun_distance(terrestrial(days))
    return distance[..., None] * sun_direction(days)


def visible_fraction(r_i: jax.Array, sun: jax.Array) -> jax.Array:
    """Fraction (...) of the sun's disk that is not hidden by a spherical Earth.

    r_i : (..., 3) [m], position.  sun : (..., 3), unit vector to the sun.
    """
    return disks(r_i, ASTRONOMICAL_UNIT * sun - r_i, EARTH_RADIUS, SUN_RADIUS).visible
