"""Unit quaternions, scalar first: q = [eta, eps].

`q_ab` is the attitude of frame b relative to frame a, and R(q_ab) maps components in b to
components in a. Hence q_ac = q_ab (x) q_bc. Every function takes arbitrary leading batch axes.
"""

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude.rotation_matrix import rotation_of
from jaxatt.attitude.rotation_vector import (
    from_axis_angle,
    from_rotation_vector,
    to_rotation_vector,
)
from jaxatt.attitude.vectors import (
    broadcast_batch,
    cross,
    dot,
    floating,
    quaternion_of,
    stack_matrix,
    tiny,
    vector_of,
)
from jaxatt.attitude.whole import compiled_whole

__all__ = [
    "canonical",
    "conjugate",
    "derivative",
    "from_axis_angle",
    "from_matrix",
    "from_rotation_vector",
    "identity",
    "multiply",
    "normalize",
    "random",
    "rotate",
    "rotate_inverse",
    "slerp",
    "to_matrix",
    "to_rotation_vector",
]


def identity(shape: tuple[int, ...] = (), dtype: jax.typing.DTypeLike | None = None) -> jax.Array:
    """Quaternion of no rotation, shape (*shape, 4), in the default float type unless told."""
    q = jnp.array([1.0, 0.0, 0.0, 0.0], dtype=dtype)
    return jnp.broadcast_to(q, (*shape, 4))


def random(
    key: jax.Array, shape: tuple[int, ...] = (), dtype: jax.typing.DTypeLike | None = None
) -> jax.Array:
    """Draw unit quaternions uniformly over all attitudes.

    Parameters
    ----------
    key : typed PRNG key
    shape : tuple of int
        Batch shape.

    Returns
    -------
    (*shape, 4)
        Of either sign of eta.
    """
    return normalize(jax.random.normal(key, (*shape, 4), dtype=dtype or jnp.result_type(float)))


@compiled_whole
def multiply(q1: ArrayLike, q2: ArrayLike) -> jax.Array:
    """Quaternion product q1 (x) q2, R(q1 (x) q2) = R(q1) R(q2); Schaanning (2021), eq. (2.35).

    Parameters
    ----------
    q1, q2 : (..., 4)

    Returns
    -------
    (..., 4)
    """
    q1, q2 = broadcast_batch(quaternion_of(q1), quaternion_of(q2))
    eta1, eps1 = q1[..., :1], q1[..., 1:]
    eta2, eps2 = q2[..., :1], q2[..., 1:]
    eta = eta1 * eta2 - dot(eps1, eps2)[..., None]
    return jnp.concatenate([eta, eta1 * eps2 + eta2 * eps1 + cross(eps1, eps2)], axis=-1)


@compiled_whole
def conjugate(q: ArrayLike) -> jax.Array:
    """Conjugate [eta, -eps], the inverse of a unit quaternion; Schaanning (2021), eq. (2.37)."""
    q = quaternion_of(q)
    return jnp.concatenate([q[..., :1], -q[..., 1:]], axis=-1)


@compiled_whole
def normalize(q: ArrayLike) -> jax.Array:
    """Scale (..., 4) to unit norm; the zero quaternion becomes the identity, with zero gradient."""
    q = quaternion_of(q)
    squared = dot(q, q)[..., None]
    vanishes = squared < tiny(q)
    unit = q / jnp.sqrt(jnp.where(vanishes, 1.0, squared))
    return jnp.where(vanishes, identity(q.shape[:-1], q.dtype), unit)


@compiled_whole
def canonical(q: ArrayLike) -> jax.Array:
    """Choose of q and -q, which are one attitude, the one with eta >= 0 (the short way)."""
    q = quaternion_of(q)
    return jnp.where(q[..., :1] < 0.0, -q, q)


@compiled_whole
def to_matrix(q: ArrayLike) -> jax.Array:
    """Rotation matrix R(q) = I + 2 eta S(eps) + 2 S(eps)^2; Schaanning (2021), eq. (2.40).

    The source labels R(q_ob) as orbit to body; with its kinematics (4.2) it must be, and here
    is, body to orbit.

    Parameters
    ----------
    q : (..., 4)
        Unit quaternion.

    Returns
    -------
    (..., 3, 3)
    """
    q = quaternion_of(q)
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    return stack_matrix(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def from_matrix(matrix: ArrayLike) -> jax.Array:
    """Unit quaternion, eta >= 0, of a rotation matrix; well conditioned for every rotation.

    The entries of the matrix give the sixteen products 4 q_j q_k. The row with the largest
    diagonal is proportional to q and has a norm of at least two, so that its normalisation is
    smooth (Shepperd 1978).

    Parameters
    ----------
    matrix : (..., 3, 3)

    Returns
    -------
    (..., 4)

    Raises
    ------
    ValueError
        The matrix is a reflection or no rotation at all, see `rotation_of`.
    """
    m = rotation_of(matrix)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    wx, wy, wz = (m[..., j, k] - m[..., k, j] for j, k in ((2, 1), (0, 2), (1, 0)))
    xy, xz, yz = (m[..., j, k] + m[..., k, j] for j, k in ((0, 1), (0, 2), (1, 2)))
    products = stack_matrix(
        [
            [1 + xx + yy + zz, wx, wy, wz],
            [wx, 1 + xx - yy - zz, xy, xz],
            [wy, xy, 1 - xx + yy - zz, yz],
            [wz, xz, yz, 1 - xx - yy + zz],
        ]
    )
    largest = jnp.argmax(jnp.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    row = jnp.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :]
    return canonical(normalize(row))


@compiled_whole
def rotate(q: ArrayLike, v: ArrayLike) -> jax.Array:
    """Rotate a vector, R(q) v: `v_o = rotate(q_ob, v_b)`.

    Parameters
    ----------
    q : (..., 4)
        Unit quaternion.
    v : (..., 3)

    Returns
    -------
    (..., 3)
    """
    q, v = broadcast_batch(quaternion_of(q), vector_of(v))
    twice = 2 * cross(q[..., 1:], v)
    return v + q[..., :1] * twice + cross(q[..., 1:], twice)


@compiled_whole
def rotate_inverse(q: ArrayLike, v: ArrayLike) -> jax.Array:
    """Rotate a vector back, R(q)' v: `v_b = rotate_inverse(q_ob, v_o)`."""
    return rotate(conjugate(q), v)


@compiled_whole
def derivative(q: ArrayLike, omega: ArrayLike) -> jax.Array:
    """Kinematics dq/dt = 1/2 q (x) [0, omega]; Schaanning (2021), eq. (4.2).

    Parameters
    ----------
    q : (..., 4)
        `q_ab`.
    omega : (..., 3) [rad/s]
        `omega_ab` in the axes of b: for `q_ob`, `omega_ob` in body axes.

    Returns
    -------
    (..., 4) [1/s]
    """
    omega = vector_of(omega, "omega")
    pure = jnp.concatenate([jnp.zeros_like(omega[..., :1]), omega], axis=-1)
    return 0.5 * multiply(q, pure)


@compiled_whole
def slerp(q0: ArrayLike, q1: ArrayLike, fraction: ArrayLike) -> jax.Array:
    """Point on the great arc from q0 to q1, taken the short way at constant rate.

    Parameters
    ----------
    q0, q1 : (..., 4)
        Unit quaternions. The arc ends at q1 or -q1, whichever is nearer to q0.
    fraction : (...)
        0 at q0, 1 at q1; values outside go on along the same rotation.

    Returns
    -------
    (..., 4)
    """
    step = to_rotation_vector(canonical(multiply(conjugate(q0), q1)))
    step, fraction = broadcast_batch(step, floating(fraction)[..., None])
    return multiply(q0, from_rotation_vector(fraction * step))
