"""Two disks in the sky: how far the Earth's covers the sun's."""

from __future__ import annotations

import math
from typing import NamedTuple

import jax
import jax.numpy as jnp

from jaxatt.attitude.components import Scalar
from jaxatt.attitude.vectors import cross, dot, norm


class Disks(NamedTuple):
    """Sun and Earth as a satellite sees them, each (...) [rad].

    sun, earth : angular radii of the disks.  apart : angle between their centres.
    """

    sun: jax.Array
    earth: jax.Array
    apart: jax.Array

    @property
    def into_penumbra(self) -> jax.Array:
        """Angle by which the disks overlap; positive in penumbra and umbra."""
        return self.sun + self.earth - self.apart

    @property
    def into_umbra(self) -> jax.Array:
        """Angle by which the sun's disk is behind the Earth's; positive in the umbra."""
        return self.earth - self.sun - self.apart

    @property
    def visible(self) -> jax.Array:
        """Fraction of the sun's disk that the Earth does not hide.

        Source: Montenbruck and Gill (2000), *Satellite Orbits*, section 3.4.2.
        """
        a, b, c = self
        partly = (c > jnp.abs(a - b)) & (c < a + b)
        middle = jnp.where(partly, c, b)
        x = (middle**2 + a**2 - b**2) / (2.0 * middle)
        inside = a**2 - x**2
        y = jnp.where(inside > 0.0, jnp.sqrt(jnp.where(inside > 0.0, inside, 1.0)), 0.0)
        hidden = (
            a**2 * jnp.arccos(jnp.clip(x / a, -1.0, 1.0))
            + b**2 * jnp.arccos(jnp.clip((middle - x) / b, -1.0, 1.0))
            - middle * y
        )
        whole = jnp.where(c >= a + b, 1.0, jnp.where(a > b, 1.0 - (b / a) ** 2, 0.0))
        return jnp.where(partly, 1.0 - hidden / (math.pi * a**2), whole)


def disks(r_i: jax.Array, to_sun: jax.Array, earth_radius: Scalar, sun_radius: Scalar) -> Disks:
    """Disks of sun and Earth, both spheres, as a satellite sees them.

    r_i : (..., 3) [m], its position.  to_sun : (..., 3) [m], from it to the sun.
    earth_radius, sun_radius : () [m].
    """
    away, radius = norm(to_sun), norm(r_i)
    apart = jnp.arctan2(norm(cross(to_sun, -r_i)), dot(to_sun, -r_i))
    return Disks(
        jnp.arcsin(sun_radius / away),
        jnp.arcsin(jnp.minimum(earth_radius / radius, 1.0)),
        apart,
    )
