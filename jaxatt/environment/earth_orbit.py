"""Longitude of the sun and its distance, from the Earth's orbit with its perturbations.

A part of the theory VSOP87 (version D, in the ecliptic and equinox of the date): Bretagnon and
Francou (1988), "Planetary theories in rectangular and spherical variables", Astronomy and
Astrophysics 202.  Terms of more than 0.4 arcsec of longitude and 3e-6 of the distance are kept.
"""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.runtime.arrays import Floats

_DAYS = 365250.0
"""Days of the theory's unit of time, a thousand Julian years."""

_ABERRATION = math.radians(20.4898 / 3600.0)
"""By how much the sun is seen behind its place, at a distance of 1 au."""

# Amplitude [1e-8 rad or 1e-8 au], phase [rad] and frequency [rad a thousand Julian years].
_LONGITUDE = np.array(
    [
        (3341656.456, 4.66925680, 6283.0758499914),
        (34894.275, 4.62610242, 12566.1516999828),
        (3497.056, 2.74411783, 5753.3848848968),
        (3417.572, 2.82886580, 3.5231183490),
        (3135.899, 3.62767042, 77713.7714681205),
        (2676.218, 4.41808345, 7860.4193924392),
        (2342.691, 6.13516214, 3930.2096962196),
        (1324.294, 0.74246342, 11506.7697697936),
        (1273.165, 2.03709658, 529.6909650946),
        (1199.167, 1.10962946, 1577.3435424478),
        (990.250, 5.23268072, 5884.9268465832),
        (901.854, 2.04505446, 26.2983197998),
        (857.223, 3.50849152, 398.1490034082),
        (779.786, 1.17882682, 5223.6939198022),
        (753.141, 2.53339053, 5507.5532386674),
        (505.0, 4.583, 18849.228),
        (492.0, 4.205, 775.523),
        (357.0, 2.920, 0.067),
        (317.0, 5.849, 11790.629),
        (284.0, 1.899, 796.298),
        (271.0, 0.315, 10977.079),
        (243.0, 0.345, 5486.778),
        (206.0, 4.806, 2544.314),
        (205.0, 1.869, 5573.143),
        (202.0, 2.458, 6069.777),
    ]
)
_LONGITUDE_IN_TIME = np.array(
    [(206058.863, 2.67823456, 6283.0758499914), (4303.430, 2.63512650, 12566.1516999828)]
)
_DISTANCE = np.array(
    [
        (1670699.626, 3.09846351, 6283.0758499914),
        (13956.023, 3.05524610, 12566.1516999828),
        (3083.720, 5.19846674, 77713.7714681205),
        (1628.461, 1.17387749, 5753.3848848968),
        (1575.568, 2.84685246, 7860.4193924392),
        (924.799, 5.45292234, 11506.7697697936),
        (542.444, 4.56409150, 3930.2096962196),
        (472.0, 3.661, 5884.927),
        (346.0, 0.964, 5507.553),
        (329.0, 5.900, 5223.694),
        (307.0, 0.299, 5573.143),
    ]
)
_DISTANCE_IN_TIME = np.array([(103018.608, 1.10748970, 6283.0758499914)])


def apparent_longitude(days: jax.Array) -> jax.Array:
    """Longitude (...) [rad] at which the sun is seen, from the mean equinox of the date.

    days : (...), of Terrestrial Time since J2000.
    Good to 2 arcsec within a century of J2000; the sun's latitude, below 1.2 arcsec, is no part.
    """
    t = days / _DAYS
    mean = 1.75347045673 + t * (6283.31966747491 + t * 0.00052918870)
    swings = _series(_LONGITUDE, t) + t * _series(_LONGITUDE_IN_TIME, t)
    return mean + swings + math.pi - _ABERRATION / sun_distance(days)


def sun_distance(days: jax.Array) -> jax.Array:
    """Distance (...) [au] between the sun and the Earth; days (...) of Terrestrial Time."""
    t = days / _DAYS
    return 1.00013988799 + _series(_DISTANCE, t) + t * _series(_DISTANCE_IN_TIME, t)


def _series(terms: Floats, t: jax.Array) -> jax.Array:
    amplitude, phase, frequency = 1e-8 * terms[:, 0], terms[:, 1], terms[:, 2]
    waves = jax.vmap(lambda a, p, f: a * jnp.cos(p + f * t))(amplitude, phase, frequency)
    return jnp.sum(waves, axis=0)
