"""Pointing constraints: cones about directions, and limits on the body rate.

A keep-out cone holds a boresight away from a direction (a star tracker from the sun), a keep-in
cone holds it near one (an antenna to its ground station).  Boresights are fixed in body axes;
directions come from outside, at rest or in motion, as tables.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Scalar, Vector

KEEP_IN, KEEP_OUT = 1.0, -1.0

_ROUNDED = 0.02
"""[rad] Up to which angle from its middle a cone's margin is rounded."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class PointingLimits:
    """Cones and rate limits; every leaf may be batched, swept or differentiated.

    boresights : (m, 3), unit vectors in body axes.
    cosines : (m,), of the half angles, which lie between 0 and pi.
    senses : (m,), `KEEP_IN` or `KEEP_OUT`.
    rate_limit : (3,) [rad/s] on |omega_ib| in each body axis, infinite where there is none; or
        (0,) without any.
    """

    boresights: Array
    cosines: Array
    senses: Array
    rate_limit: Array

    @property
    def count(self) -> int:
        """Number of cones m."""
        return int(self.cosines.shape[-1])

    @property
    def rows(self) -> int:
        """Number of margins: one a cone and two a limited axis."""
        return self.count + 2 * int(self.rate_limit.shape[-1])


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class PointingPath:
    """Pointing limits along a flight of N intervals.

    limits : what holds all the way.  directions : (N + 1, m, 3), unit vectors in inertial axes at
    the nodes.
    """

    limits: PointingLimits
    directions: Array


NO_POINTING = PointingPath(
    PointingLimits(np.zeros((0, 3)), np.zeros(0), np.zeros(0), np.zeros(0)),  # type: ignore[arg-type]
    np.zeros((1, 0, 3)),  # type: ignore[arg-type]
)
"""A flight that may point anywhere at any rate."""


def pointing_margins(
    q_ib: Array, omega_ib: Array, directions: Array, limits: PointingLimits
) -> Array:
    """Margins at one instant, non-negative where limits hold, (m + 6,), or (m,) without rates.

    q_ib : (4,), unit norm.  omega_ib : (3,) [rad/s] in body axes.
    directions : (m, 3), unit vectors in inertial axes at that instant.

    A cone's margin grows with the chord between boresight and direction, 2 sin(angle/2), rounded in
    the middle of the cone: smooth everywhere, near the cone's surface the angle [rad] that is left,
    and in its middle, where the cosine is flat, still steep.  Those of a rate are 1 -+ omega/limit.
    """
    # In components: under `vmap` with the batch axis last each is one contiguous vector.
    q = Quaternion.of(q_ib)
    rows = []
    for i in range(limits.count):
        boresight, direction = Vector.of(limits.boresights[i]), Vector.of(directions[i])
        cosine = q.rotate(boresight).dot(direction)
        rows.append(cone_margin(cosine, limits.cosines[i], limits.senses[i]))
    rows += rate_margins(omega_ib, limits)
    return jnp.stack(rows) if rows else jnp.zeros((0,), q_ib.dtype)


def cone_margin(cosine: Scalar, edge: Array, sense: Array) -> Array:
    """Margin () of one cone, from the cosines of its angle and of its half angle."""
    chord, border = (jnp.sqrt(2.0 - 2.0 * c + _ROUNDED * _ROUNDED) for c in (cosine, edge))
    return jnp.asarray(sense * (border - chord) * border * lax.rsqrt(1.0 - edge * edge))


def rate_margins(omega_ib: Array, limits: PointingLimits) -> list[Array]:
    """Margins of the limited rates, upper limits first, each ()."""
    count = limits.rate_limit.shape[-1]
    relative = [omega_ib[i] / limits.rate_limit[i] for i in range(count)]
    return [1.0 - r for r in relative] + [1.0 + r for r in relative]


def cone_angles(q_ib: Array, directions: Array, boresights: Array) -> Array:
    """Angles (..., m) [rad] between boresights and directions, accurate near 0 and pi too.

    q_ib : (..., 4).  directions : (..., m, 3), unit vectors in inertial axes.
    boresights : (m, 3), unit vectors in body axes.
    """
    boresights = jnp.broadcast_to(boresights, directions.shape)
    turned = Quaternion.of(q_ib[..., None, :]).rotate(Vector.of(boresights))
    other = Vector.of(directions)
    return jnp.arctan2(turned.cross(other).norm(), turned.dot(other))
