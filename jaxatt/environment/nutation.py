"""Nutation: how the Earth's axis nods about its mean direction, and the ecliptic's obliquity."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from jaxatt.environment.epoch import DAYS_PER_CENTURY


class Nutation(NamedTuple):
    """Nutation in longitude and in obliquity, each (...) [rad]."""

    longitude: jax.Array
    obliquity: jax.Array


def nutation(days: jax.Array) -> Nutation:
    """Nutation at a date by its four largest terms, within 0.5 arcsec; days (...) since J2000.

    Source: Meeus (1998), "Astronomical Algorithms", chapter 22.
    """
    t = days / DAYS_PER_CENTURY
    node = jnp.deg2rad(125.04452 - 1934.136261 * t)
    sun = 2.0 * jnp.deg2rad(280.4665 + 36000.7698 * t)
    moon = 2.0 * jnp.deg2rad(218.3165 + 481267.8813 * t)
    across = -17.20 * jnp.sin(node) - 1.32 * jnp.sin(sun) - 0.23 * jnp.sin(moon)
    along = 9.20 * jnp.cos(node) + 0.57 * jnp.cos(sun) + 0.10 * jnp.cos(moon)
    return Nutation(
        arcsec(across + 0.21 * jnp.sin(2.0 * node)), arcsec(along - 0.09 * jnp.cos(2.0 * node))
    )


def mean_obliquity(days: jax.Array) -> jax.Array:
    """Angle (...) [rad] between the ecliptic and the mean equator; days (...) since J2000.

    Source: Capitaine, Wallace and Chapront (2003), IAU 2006, eq. (39).
    """
    t = days / DAYS_PER_CENTURY
    return arcsec(84381.406 + t * (-46.836769 + t * (-0.0001831 + t * 0.00200340)))


def arcsec(value: jax.Array) -> jax.Array:
    """Angle [rad] from seconds of arc."""
    return jnp.deg2rad(value / 3600.0)
