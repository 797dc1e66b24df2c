"""The Earth as an ellipsoid: where a line of sight meets the ground."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import broadcast_batch

EQUATORIAL_RADIUS = 6378137.0
"""WGS 84 [m]."""

POLAR_RADIUS = 6356752.314245
"""WGS 84 [m]."""


def ground_point(position: ArrayLike, direction: ArrayLike) -> jax.Array:
    """First point (..., 3) [m] of the ellipsoid along a line of sight; nan where it misses.

    position : (..., 3) [m], outside the Earth, and direction : (..., 3), of any length, both in
    axes whose z is the Earth's.
    """
    radii = jnp.array([EQUATORIAL_RADIUS, EQUATORIAL_RADIUS, POLAR_RADIUS])
    position, direction, radii = broadcast_batch(position, direction, radii)
    p, d = position / radii, direction / radii
    a = jnp.sum(d * d, axis=-1)
    b = jnp.sum(p * d, axis=-1)
    c = jnp.sum(p * p, axis=-1) - 1.0
    root = b * b - a * c
    distance = jnp.where((root >= 0.0) & (b < 0.0), (-b - jnp.sqrt(jnp.abs(root))) / a, jnp.nan)
    return position + distance[..., None] * direction
