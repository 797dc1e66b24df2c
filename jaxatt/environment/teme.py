"""The frame of SGP4, true equator and mean equinox (TEME), against the inertial axes of J2000."""

from __future__ import annotations

import math

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment.epoch import DAYS_PER_CENTURY, EARTH_RATE, SECONDS_PER_DAY
from jaxatt.environment.precession import about_z, earth_fixed
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE

_BLOCK = 1024  # instants of one compiled evaluation


def sidereal_angle_1982(days: jax.Array) -> jax.Array:
    """Greenwich mean sidereal time (...) [rad] of 1982, by which TEME is tied to the Earth.

    days : (...), since J2000, with UTC taken for UT1.
    Source: Vallado, Crawford, Hujsak and Kelso (2006), "Revisiting spacetrack report #3", app. C.
    """
    t = days / DAYS_PER_CENTURY
    seconds = 67310.54841 + t * (8640184.812866 + t * (0.093104 - t * 6.2e-6))
    turns = (days - jnp.floor(days)) + seconds / SECONDS_PER_DAY
    return 2.0 * math.pi * (turns - jnp.floor(turns))


def from_teme(days: jax.Array) -> jax.Array:
    """Rotation matrix (..., 3, 3) from TEME to inertial axes; days (...) since J2000.

    Both lead to the same Earth-fixed axes, so that precession, nutation and the equation of the
    equinoxes are those of `precession.earth_fixed`.  TEME of the date turns by 50 arcsec a year,
    which is 6e-5 m/s in a low orbit and is left out of velocities.
    """
    to_earth = about_z(sidereal_angle_1982(days))
    back = jnp.swapaxes(earth_fixed(days), -1, -2)
    return jnp.matmul(back, to_earth, precision="highest")


_from_teme = jax.jit(from_teme, compiler_options=RUNS_ONCE)
_earth_fixed = jax.jit(earth_fixed, compiler_options=RUNS_ONCE)


def inertial_of_teme(days: Floats, *vectors: Floats) -> tuple[Floats, ...]:
    """Vectors (n, 3) of TEME in inertial axes, on the host; days (n,) since J2000."""
    turn = _blockwise(_from_teme, days)
    return tuple(np.einsum("nij,nj->ni", turn, vector) for vector in vectors)


def inertial_of_earth_fixed(days: Floats, r: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Position (n, 3) [m] and velocity (n, 3) [m/s] of Earth-fixed axes in inertial ones.

    days : (n,) since J2000.  The velocity is the one that is seen on the turning Earth.
    """
    turn = np.swapaxes(_blockwise(_earth_fixed, days), -1, -2)
    carried = v + EARTH_RATE * np.stack([-r[:, 1], r[:, 0], np.zeros(len(r))], axis=1)
    return np.einsum("nij,nj->ni", turn, r), np.einsum("nij,nj->ni", turn, carried)


def _blockwise(matrices: jax.stages.Wrapped, days: Floats) -> Floats:
    with jax.enable_x64(True):
        padded = np.pad(days, (0, -len(days) % _BLOCK), mode="edge").reshape(-1, _BLOCK)
        return np.concatenate([np.asarray(matrices(block)) for block in padded])[: len(days)]
