"""Measures of the difference between two attitudes.

None of these measures tells q from -q, except `error_quaternion`.
"""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.vectors import dot, floating, norm, quaternion_of
from jaxatt.attitude.whole import compiled_whole

SMOOTHING = 1e-8
"""Default alpha of the smooth maximum; the source leaves it open."""


@compiled_whole
def error_quaternion(q_ref: ArrayLike, q: ArrayLike) -> jax.Array:
    """Attitude relative to the reference, q_ref^-1 (x) q; Schaanning (2021), eq. (4.15).

    Parameters
    ----------
    q_ref, q : (..., 4)
        Unit quaternions.

    Returns
    -------
    (..., 4)
        `[1, 0, 0, 0]`, or its negative, when the attitudes agree.
    """
    return quaternion.multiply(quaternion.conjugate(q_ref), q)


@compiled_whole
def angle(q_ref: ArrayLike, q: ArrayLike) -> jax.Array:
    """Angle of the shortest rotation between two attitudes.

    Computed as 2 atan2(|eps|, |eta|) of the error quaternion, which is accurate near zero and
    near pi, where the arc cosine and the arc sine are not, and does not depend on the norms.

    Parameters
    ----------
    q_ref, q : (..., 4)

    Returns
    -------
    (...) [rad]
        In [0, pi]. Kinked at both ends: zero gradient along the kink is used there.
    """
    error = error_quaternion(q_ref, q)
    return 2 * jnp.arctan2(norm(error[..., 1:]), jnp.abs(error[..., 0]))


@compiled_whole
def rotation_vector(q_ref: ArrayLike, q: ArrayLike) -> jax.Array:
    """Shortest rotation that takes the reference to q.

    Parameters
    ----------
    q_ref, q : (..., 4)
        Unit quaternions.

    Returns
    -------
    (..., 3) [rad]
        In body axes, of length at most pi; of the two that are exactly pi long, the one of the
        given sign of the error quaternion.
    """
    return quaternion.to_rotation_vector(quaternion.canonical(error_quaternion(q_ref, q)))


@compiled_whole
def pseudo_metric(q_ref: ArrayLike, q: ArrayLike) -> jax.Array:
    """Distance 1 - |q' q_ref|, from 0 (same attitude) to 1 (180 degrees apart).

    Schaanning (2021), eq. (5.2). Kinked at 180 degrees, where its gradient is taken as zero.

    Parameters
    ----------
    q_ref, q : (..., 4)
        Unit quaternions.

    Returns
    -------
    (...)
    """
    return 1 - jnp.abs(dot(quaternion_of(q_ref), quaternion_of(q)))


@compiled_whole
def smooth_pseudo_metric(q_ref: ArrayLike, q: ArrayLike, alpha: ArrayLike = SMOOTHING) -> jax.Array:
    """Distance (5.2) with its absolute value smoothed by (2.48), as Schaanning (2021) codes it.

    Parameters
    ----------
    q_ref, q : (..., 4)
        Unit quaternions.
    alpha : (...)
        Smoothing.

    Returns
    -------
    (...)
        Below `pseudo_metric` by sqrt(alpha) / 2 at 180 degrees and alpha / 8 when aligned, where
        it is therefore slightly negative.
    """
    return 1 - smooth_abs(dot(quaternion_of(q_ref), quaternion_of(q)), alpha)


@compiled_whole
def smooth_maximum(x1: ArrayLike, x2: ArrayLike, alpha: ArrayLike = SMOOTHING) -> jax.Array:
    """Smooth max(x1, x2) = (x1 + x2 + sqrt((x1 - x2)^2 + alpha)) / 2, from above.

    Schaanning (2021), eq. (2.48). All arguments and the result are (...); alpha > 0.
    """
    x1, x2 = floating(x1), floating(x2)
    return 0.5 * (x1 + x2 + jnp.sqrt((x1 - x2) ** 2 + alpha))


@compiled_whole
def smooth_abs(x: ArrayLike, alpha: ArrayLike = SMOOTHING) -> jax.Array:
    """Smooth |x| = smooth max(x, -x) = sqrt(x^2 + alpha / 4), shape (...); alpha > 0."""
    x = floating(x)
    return smooth_maximum(x, -x, alpha)
