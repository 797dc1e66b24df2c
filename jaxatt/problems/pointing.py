"""Where a body may point and how fast it may turn: cones about directions, limits on its rate.

A keep-out cone holds a boresight away from a direction (a star tracker from the sun), a keep-in
cone holds it near one (an antenna to its ground station).  Boresights are fixed in body axes;
directions come from outside, fixed, along the orbit or to the sun.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Quaternion, Vector

KEEP_IN, KEEP_OUT = 1.0, -1.0


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


def pointing_margins(
    q_ib: Array, omega_ib: Array, directions: Array, limits: PointingLimits
) -> Array:
    """Margins at one instant, non-negative where the limits hold, (m + 6,), or (m,) without rates.

    q_ib : (4,), unit norm.  omega_ib : (3,) [rad/s] in body axes.
    directions : (m, 3), unit vectors in inertial axes at that instant.

    A cone's margin is +-(cos angle - cos half_angle) / sin half_angle: smooth everywhere, and near
    the cone's surface the angle [rad] that is left.  A rate's margins are 1 -+ omega / limit.
    """
    # In components: under `vmap` with the batch axis last each is one contiguous vector.
    q, rows = Quaternion.of(q_ib), []
    for i in range(limits.count):
        cosine, edge = _seen(q, limits.boresights[i], directions[i]), limits.cosines[i]
        sine = jnp.sqrt(1.0 - edge * edge)
        rows.append(limits.senses[i] * (cosine - edge) / sine)
    for sign in (-1.0, 1.0):
        for i in range(limits.rate_limit.shape[-1]):
            rows.append(1.0 + sign * omega_ib[i] / limits.rate_limit[i])
    return jnp.stack(rows) if rows else jnp.zeros((0,), q_ib.dtype)


def _seen(q: Quaternion, boresight: Array, direction: Array) -> Array:
    """Cosine of the angle between a boresight in body axes and a direction in inertial axes."""
    turned = q.rotate(Vector.of(boresight))
    return jnp.asarray(turned.dot(Vector.of(direction)))


def cone_angles(q_ib: Array, directions: Array, boresights: Array) -> Array:
    """Angles (..., m) [rad] between boresights and directions, accurate near 0 and pi too.

    q_ib : (..., 4).  directions : (..., m, 3), unit vectors in inertial axes.
    boresights : (m, 3), unit vectors in body axes.
    """
    boresights = jnp.broadcast_to(boresights, directions.shape)
    turned = Quaternion.of(q_ib[..., None, :]).rotate(Vector.of(boresights))
    other = Vector.of(directions)
    return jnp.arctan2(turned.cross(other).norm(), turned.dot(other))
