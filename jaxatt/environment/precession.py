"""Axes of the Earth at a date, against the inertial axes, which are those of J2000.

The inertial frame of the whole package is the mean equator and equinox of J2000 (EME2000), within
0.03 arcsec of the celestial reference frame.  The equator and the equinox of a date are 0.36 deg
away from it after 26 years.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp

from jaxatt.attitude.vectors import stack_matrix
from jaxatt.environment.epoch import DAYS_PER_CENTURY, rotation_angle
from jaxatt.environment.nutation import arcsec, mean_obliquity, nutation


def precession(days: jax.Array) -> jax.Array:
    """Rotation matrix (..., 3, 3) from inertial axes to the mean equator and equinox of a date.

    days : (...), since J2000.
    Source: Capitaine, Wallace and Chapront (2003), IAU 2006, eq. (40).
    """
    t = days / DAYS_PER_CENTURY
    zeta = arcsec(2.650545 + t * (2306.083227 + t * (0.2988499 + t * 0.01801828)))
    z = arcsec(-2.650545 + t * (2306.077181 + t * (1.0927348 + t * 0.01826837)))
    theta = arcsec(t * (2004.191903 + t * (-0.4294934 - t * 0.04182264)))
    return _product(about_z(-z), _product(_about_y(theta), about_z(-zeta)))


def earth_fixed(days: jax.Array) -> jax.Array:
    """Rotation matrix (..., 3, 3) from inertial to Earth-fixed axes.

    days : (...), since J2000, with UTC taken for UT1: up to 0.004 deg about the Earth's axis.
    What is left out besides, polar motion and the smaller terms of nutation, is below 0.0003 deg.
    """
    mean, nod = mean_obliquity(days), nutation(days)
    apparent = sidereal_angle(days) + nod.longitude * jnp.cos(mean + nod.obliquity)
    nodded = _product(_about_x(-mean - nod.obliquity), about_z(-nod.longitude))
    true = _product(nodded, _product(_about_x(mean), precession(days)))
    return _product(about_z(apparent), true)


def sidereal_angle(days: jax.Array) -> jax.Array:
    """Greenwich mean sidereal time (...) [rad]; IAU 2006, the IERS conventions (2010), eq. (5.32).

    days : (...), since J2000, with UTC taken for UT1.
    """
    t = days / DAYS_PER_CENTURY
    return rotation_angle(days) + arcsec(0.014506 + t * (4612.156534 + t * 1.3915817))


def about_z(angle: jax.Array) -> jax.Array:
    """Matrix (..., 3, 3) that turns the axes by an angle (...) [rad] about z."""
    cos, sin, zero = jnp.cos(angle), jnp.sin(angle), jnp.zeros_like(angle)
    return stack_matrix([[cos, sin, zero], [-sin, cos, zero], [zero, zero, zero + 1.0]])


def _about_x(angle: jax.Array) -> jax.Array:
    cos, sin, zero = jnp.cos(angle), jnp.sin(angle), jnp.zeros_like(angle)
    return stack_matrix([[zero + 1.0, zero, zero], [zero, cos, sin], [zero, -sin, cos]])


def _about_y(angle: jax.Array) -> jax.Array:
    cos, sin, zero = jnp.cos(angle), jnp.sin(angle), jnp.zeros_like(angle)
    return stack_matrix([[cos, zero, -sin], [zero, zero + 1.0, zero], [sin, zero, cos]])


def _product(a: jax.Array, b: jax.Array) -> jax.Array:
    # Some devices round the inputs of a matrix product unless told otherwise.
    return jnp.matmul(a, b, precision="highest")
