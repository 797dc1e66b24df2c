"""What the end of a manoeuvre must satisfy: rows that vanish at the target, all in radians.

A target holds the body about three axes, or about the two across a boresight, whose roll is then
free: which of the two is in the shape of `held`, (3, 3) or (2, 3).
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import quaternion

RATE_SCALE = 10.0
"""[s] A rate error of 1 rad/s counts as 10 rad: over the last ten seconds it would turn as much."""

_LEAST = 1e-12


def attitude_row(reference: Array, q: Array) -> Array:
    """Attitude error 4 sin(phi/4) about its axis, (3,), smooth from 0 to 2 pi.

    Its squared norm is 8 (1 - |q' q_ref|), so the attitude cost g of (5.2) is an eighth of it.
    """
    error = quaternion.multiply(quaternion.conjugate(reference), q)
    return 2.0 * error[1:] * jnp.sqrt(2.0 / jnp.maximum(1.0 + error[0], _LEAST))


def attitude_rows(reference: Array, q: Array, held: Array) -> Array:
    """Attitude error about the body axes that are held, (3,) or (2,).

    Of a boresight it is 4 sin(theta/4) long, theta the angle between its direction and the wanted
    one; its axes turn by half the roll from the reference, so that it is smooth at every roll, and
    has full rank wherever theta is not 180 deg.

    reference, q : (4,).  held : (3, 3), or (2, 3), unit body axes across the boresight.
    """
    if held.shape[0] == 3:
        return attitude_row(reference, q)
    error = quaternion.multiply(quaternion.conjugate(reference), q)
    swing = held[:, 0] * error[1] + held[:, 1] * error[2] + held[:, 2] * error[3]
    # The other two components, whatever the roll is.
    cosine = jnp.sqrt(jnp.maximum(1.0 - jnp.sum(swing**2), _LEAST))
    return 2.0 * swing * jnp.sqrt(2.0 / (1.0 + cosine))


def swing_slope(reference: Array, q: Array, held: Array) -> Array:
    """Derivative (2, 3) of the rows of a boresight by a small turn in the axes of reference.

    Exact where the boresight has its direction, and of full rank everywhere.
    """
    error = quaternion.multiply(quaternion.conjugate(reference), q)
    boresight = jnp.cross(held[0], held[1])
    along = jnp.stack([error[0], jnp.sum(boresight * error[1:])])
    size = jnp.sqrt(jnp.sum(along**2))
    w, twist = jnp.where(size > _LEAST, along / jnp.maximum(size, _LEAST), jnp.array([1.0, 0.0]))
    first, second = quaternion.rotate(reference, held[0]), quaternion.rotate(reference, held[1])
    return jnp.stack([w * first + twist * second, w * second - twist * first])


def rolled_rate(reference: Array, rate: Array, q: Array, held: Array) -> Array:
    """Rate (3,) to end with in body axes; where the roll is free, it turns with the frame's axes.

    rate : (3,), in the body axes of the reference (4,).  q : (4,), where the body ends.
    """
    if held.shape[0] == 3:
        return rate
    return quaternion.rotate_inverse(quaternion.multiply(quaternion.conjugate(reference), q), rate)
