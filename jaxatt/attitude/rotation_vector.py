"""Exponential and logarithm of unit quaternions: rotation vectors, axis with angle.

Reached as `quaternion.from_rotation_vector` and so on.
"""

import math

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import broadcast_batch, dot, floating, quaternion_of, tiny, vector_of
from jaxatt.attitude.whole import compiled_whole

# Below these squared (half-)angles the truncated series are exact to double precision, as are
# their first derivatives.
_EXP_SERIES_BELOW = 1e-2
_LOG_SERIES_BELOW = 1e-3


@compiled_whole
def from_rotation_vector(vector: ArrayLike) -> jax.Array:
    """Quaternion of the rotation by |vector| about vector; Schaanning (2021), eq. (2.32).

    Smooth everywhere, whatever the length of the vector.

    Parameters
    ----------
    vector : (..., 3) [rad]

    Returns
    -------
    (..., 4)
    """
    vector = vector_of(vector, "rotation vector")
    squared = dot(vector, vector)[..., None]
    small = squared < _EXP_SERIES_BELOW
    x = jnp.where(small, squared, 0.0)
    cos_series = 1 - x / 8 * (1 - x / 48 * (1 - x / 120 * (1 - x / 224)))
    sin_series = 0.5 - x / 48 * (1 - x / 80 * (1 - x / 168 * (1 - x / 288)))
    angle = jnp.sqrt(jnp.where(small, 1.0, squared))
    eta = jnp.where(small, cos_series, jnp.cos(angle / 2))
    factor = jnp.where(small, sin_series, jnp.sin(angle / 2) / angle)
    return jnp.concatenate([eta, factor * vector], axis=-1)


@compiled_whole
def to_rotation_vector(q: ArrayLike) -> jax.Array:
    """Rotation vector of a quaternion on the branch that is continuous through 180 degrees.

    The angle is 2 atan2(|eps|, eta), in [0, 2 pi]. So q and -q, one attitude, give different
    vectors: with eta >= 0 the short way, with eta < 0 the long way round; pass
    `quaternion.canonical(q)` for the short one. The only singular point is eta = -1, a full turn
    about no particular axis: there the x axis is taken, with zero gradient.

    Parameters
    ----------
    q : (..., 4)
        Quaternion; its norm does not matter.

    Returns
    -------
    (..., 3) [rad]
    """
    q = quaternion_of(q)
    eta, eps = q[..., :1], q[..., 1:]
    squared = dot(eps, eps)[..., None]
    small = (eta > 0.0) & (squared < _LOG_SERIES_BELOW * eta * eta)
    no_axis = ~small & (eta <= 0.0) & (squared < tiny(q))

    cosine = jnp.where(small, eta, 1.0)
    x = jnp.where(small, squared, 0.0) / (cosine * cosine)
    series = 1 - x * (1 / 3 - x * (1 / 5 - x * (1 / 7 - x * (1 / 9 - x / 11))))
    sine = jnp.sqrt(jnp.where(small | no_axis, 1.0, squared))
    factor = jnp.where(small, series / cosine, jnp.arctan2(sine, eta) / sine)
    full_turn = jnp.broadcast_to(jnp.array([2 * math.pi, 0.0, 0.0], dtype=q.dtype), eps.shape)
    return jnp.where(no_axis, full_turn, 2 * factor * eps)


@compiled_whole
def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> jax.Array:
    """Quaternion of a turn by an angle about an axis; Schaanning (2021), eq. (2.32).

    Parameters
    ----------
    axis : (..., 3)
        Of any length; a zero axis gives the identity.
    angle : (...) [rad]

    Returns
    -------
    (..., 4)
    """
    axis, half = broadcast_batch(vector_of(axis, "axis"), 0.5 * floating(angle)[..., None])
    squared = dot(axis, axis)[..., None]
    no_axis = squared < tiny(squared)
    unit = axis / jnp.sqrt(jnp.where(no_axis, 1.0, squared))
    eta = jnp.where(no_axis, 1.0, jnp.cos(half))
    return jnp.concatenate([eta, jnp.sin(half) * unit], axis=-1)
