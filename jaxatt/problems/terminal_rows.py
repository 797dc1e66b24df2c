"""Terminal errors that families share: rows that vanish at the target, all in radians."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import quaternion

RATE_SCALE = 10.0
"""[s] A rate error of 1 rad/s counts as 10 rad: over the last ten seconds it would turn as much."""


def attitude_row(reference: Array, q: Array) -> Array:
    """Attitude error 4 sin(phi/4) about its axis, (3,), smooth from 0 to 2 pi.

    Its squared norm is 8 (1 - |q' q_ref|), so the attitude cost g of (5.2) is an eighth of it.
    """
    error = quaternion.multiply(quaternion.conjugate(reference), q)
    return 2.0 * error[1:] * jnp.sqrt(2.0 / jnp.maximum(1.0 + error[0], 1e-12))
