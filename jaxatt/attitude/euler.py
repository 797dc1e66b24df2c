"""Roll, pitch and yaw: R_b^o = R_z(psi) R_y(theta) R_x(phi), angles ordered (phi, theta, psi).

Schaanning (2021), eq. (2.22) and (2.23), where (2.22) names the product R_a^b; as in (2.24), it
maps components in the rotated frame to components in the fixed one.
"""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.rotation_matrix import rotation_of
from jaxatt.attitude.vectors import resolution, stack_matrix, vector_of
from jaxatt.attitude.whole import compiled_whole


@compiled_whole
def to_matrix(angles: ArrayLike) -> jax.Array:
    """Rotation matrix of roll, pitch and yaw; Schaanning (2021), eq. (2.22).

    Parameters
    ----------
    angles : (..., 3) [rad]
        (phi, theta, psi).

    Returns
    -------
    (..., 3, 3)
        R(q_ob), body to orbit.
    """
    angles = vector_of(angles, "angles")
    sin, cos = jnp.sin(angles), jnp.cos(angles)
    s1, s2, s3 = sin[..., 0], sin[..., 1], sin[..., 2]
    c1, c2, c3 = cos[..., 0], cos[..., 1], cos[..., 2]
    return stack_matrix(
        [
            [c3 * c2, c3 * s2 * s1 - s3 * c1, c3 * s2 * c1 + s3 * s1],
            [s3 * c2, s3 * s2 * s1 + c3 * c1, s3 * s2 * c1 - c3 * s1],
            [-s2, c2 * s1, c2 * c1],
        ]
    )


@compiled_whole
def to_quaternion(angles: ArrayLike) -> jax.Array:
    """Unit quaternion q_z (x) q_y (x) q_x of roll, pitch and yaw.

    Parameters
    ----------
    angles : (..., 3) [rad]
        (phi, theta, psi). A full turn in one angle changes the sign of the quaternion.

    Returns
    -------
    (..., 4)
        `q_ob`.
    """
    half = 0.5 * vector_of(angles, "angles")
    sin, cos = jnp.sin(half), jnp.cos(half)
    s1, s2, s3 = sin[..., 0], sin[..., 1], sin[..., 2]
    c1, c2, c3 = cos[..., 0], cos[..., 1], cos[..., 2]
    return jnp.stack(
        [
            c3 * c2 * c1 + s3 * s2 * s1,
            c3 * c2 * s1 - s3 * s2 * c1,
            c3 * s2 * c1 + s3 * c2 * s1,
            s3 * c2 * c1 - c3 * s2 * s1,
        ],
        axis=-1,
    )


def from_matrix(matrix: ArrayLike) -> jax.Array:
    """Roll, pitch and yaw of a rotation matrix, accurate up to and at gimbal lock.

    At theta = +-90 degrees only psi -+ phi is defined; phi = 0 is returned, with zero gradient,
    and psi carries the turn. Near it phi and psi are ill determined one by one, but the angles
    together reproduce the matrix to rounding, since psi and theta are taken from the matrix with
    the roll undone rather than each from its own entries.

    Parameters
    ----------
    matrix : (..., 3, 3)

    Returns
    -------
    (..., 3) [rad]
        phi and psi in [-pi, pi], theta in [-pi/2, pi/2].

    Raises
    ------
    ValueError
        The matrix is a reflection or no rotation at all, see `rotation_of`.
    """
    m = rotation_of(matrix)
    y, x = m[..., 2, 1], m[..., 2, 2]
    locked = y * y + x * x < (10 * resolution(m)) ** 2
    phi = jnp.arctan2(jnp.where(locked, 0.0, y), jnp.where(locked, 1.0, x))
    sin, cos = jnp.sin(phi), jnp.cos(phi)
    psi = jnp.arctan2(
        sin * m[..., 0, 2] - cos * m[..., 0, 1], cos * m[..., 1, 1] - sin * m[..., 1, 2]
    )
    cos_theta = jnp.cos(psi) * m[..., 0, 0] + jnp.sin(psi) * m[..., 1, 0]
    # Negative only by rounding, where phi was set to zero.
    theta = jnp.arctan2(-m[..., 2, 0], jnp.abs(cos_theta))
    return jnp.stack([phi, theta, psi], axis=-1)


def from_quaternion(q: ArrayLike) -> jax.Array:
    """Roll, pitch and yaw (..., 3) [rad] of a unit quaternion (..., 4); see `from_matrix`."""
    return from_matrix(quaternion.to_matrix(q))
