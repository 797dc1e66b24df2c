"""The Earth's shadow: umbra and penumbra between cones, exact or with gradual edges."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar
from jaxatt.environment.occultation import Disks, disks

SPHERICAL_EARTH_RADIUS = 6.371e6
"""Mean radius [m] of the Earth, as Kristiansen (2023), table 5.5."""

SUN_RADIUS = 6.9634e8
"""Radius [m] of the sun, as Kristiansen (2023), table 5.5."""

_DISK = 2.7  # radii of a disk over which a gradual rise is nearest to its share, within 0.02


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Shadow:
    """Shadow of a spherical Earth in the light of a spherical sun.

    penumbra : (), share of the light that reaches the whole penumbra; None for the share of the
        sun's disk that is seen from each place.
    earth_radius, sun_radius : () [m].
    """

    penumbra: Array | float | None = 0.2
    earth_radius: Array | float = SPHERICAL_EARTH_RADIUS
    sun_radius: Array | float = SUN_RADIUS

    def disks(self, r_i: Array, to_sun: Array) -> Disks:
        """Sun and Earth as seen from r_i (..., 3) [m]; to_sun : (..., 3) [m], from there."""
        return disks(r_i, to_sun, self.earth_radius, self.sun_radius)


def lit_share(shadow: Shadow, r_i: Array, to_sun: Array, width: Scalar = 0.0) -> Array:
    """Share (...) of the sun's irradiance that reaches a satellite: 1 in light, 0 in umbra.

    A satellite is inside the cones of the source's algorithm 1 exactly where it sees the Earth's
    disk touch the sun's (penumbra) or cover it (umbra), which is what is compared here.

    r_i : (..., 3) [m], its position.  to_sun : (..., 3) [m], from it to the sun.
    width : () [rad], angle in which the share changes gradually at every edge; 0 is exact.  With
        the sun's disk itself (`penumbra` None) it is added to the width of the penumbra.
    Source: Kristiansen (2023), algorithm 1.
    """
    seen = shadow.disks(r_i, to_sun)
    gradual = gradual_share(shadow, seen, width)
    if shadow.penumbra is None:
        return jnp.where(jnp.asarray(width) > 0.0, gradual, seen.visible)
    return gradual


def gradual_share(shadow: Shadow, seen: Disks, width: Scalar) -> Array:
    """Share (...) of the sun's irradiance by what is seen, with edges of some width [rad] > 0."""
    if shadow.penumbra is None:
        return 1.0 - _step(seen.earth - seen.apart, width + _DISK * seen.sun)
    half, full = _step(seen.into_penumbra, width), _step(seen.into_umbra, width)
    return (1.0 - half) + shadow.penumbra * (half - full)


def _step(angle: Array, width: Scalar) -> Array:
    """Rise from 0 to 1 around an angle of zero, twice differentiable where it has a width."""
    wide = jnp.asarray(width) > 0.0
    x = jnp.clip(angle / jnp.where(wide, width, 1.0) + 0.5, 0.0, 1.0)
    return jnp.where(wide, x**3 * (10.0 - 15.0 * x + 6.0 * x**2), jnp.where(angle > 0.0, 1.0, 0.0))
