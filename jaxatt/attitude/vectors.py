"""Small vector algebra over arbitrary leading batch axes."""

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from jaxatt.attitude.whole import compiled_whole


def floating(x: ArrayLike) -> jax.Array:
    """Return `x` as a JAX array of floating type, leaving float32 and float64 as they are."""
    array = jnp.asarray(x)
    if jnp.issubdtype(array.dtype, jnp.floating):
        return array
    return array.astype(jnp.result_type(float))


def sized(x: ArrayLike, *size: int, name: str) -> jax.Array:
    """Return `floating(x)`, whose last axes must have this size.

    name : what the message calls it.  Raises `ValueError`.
    """
    array = floating(x)
    if array.shape[-len(size) :] != size:
        wanted = ", ".join(str(n) for n in size)
        raise ValueError(f"{name}: has shape {array.shape}; give an array of shape (..., {wanted})")
    return array


def quaternion_of(x: ArrayLike) -> jax.Array:
    """Return the components (..., 4) of a quaternion, scalar first; raises `ValueError`."""
    return sized(x, 4, name="quaternion")


def vector_of(x: ArrayLike, name: str = "vector") -> jax.Array:
    """Return the components (..., 3) of a vector; raises `ValueError`."""
    return sized(x, 3, name=name)


def tiny(array: jax.Array) -> float:
    """Smallest normal number of the array's type; a squared norm below it counts as zero."""
    return float(np.finfo(array.dtype).tiny)


def resolution(array: jax.Array) -> float:
    """Spacing of the array's type at one."""
    return float(np.finfo(array.dtype).eps)


def broadcast_batch(*arrays: ArrayLike) -> tuple[jax.Array, ...]:
    """Broadcast all axes but the last against each other.

    Parameters
    ----------
    *arrays : (..., n_k)
        Components on the last axis; its length may differ from array to array.

    Returns
    -------
    tuple of (..., n_k)
        The same arrays over their common leading axes.
    """
    given = [floating(array) for array in arrays]
    batch = jnp.broadcast_shapes(*(array.shape[:-1] for array in given))
    return tuple(jnp.broadcast_to(array, batch + array.shape[-1:]) for array in given)


@compiled_whole
def dot(a: ArrayLike, b: ArrayLike) -> jax.Array:
    """Scalar product over the last axis, shape (...)."""
    a, b = broadcast_batch(a, b)
    return jnp.sum(a * b, axis=-1)


@compiled_whole
def cross(a: ArrayLike, b: ArrayLike) -> jax.Array:
    """Vector product a x b = S(a) b over the last axis, shape (..., 3)."""
    a, b = broadcast_batch(vector_of(a), vector_of(b))
    a1, a2, a3 = a[..., 0], a[..., 1], a[..., 2]
    b1, b2, b3 = b[..., 0], b[..., 1], b[..., 2]
    return jnp.stack([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1], axis=-1)


@compiled_whole
def skew(v: ArrayLike) -> jax.Array:
    """Skew-symmetric matrix S(v) with S(v) w = v x w; Schaanning (2021), eq. (2.5).

    Parameters
    ----------
    v : (..., 3)

    Returns
    -------
    (..., 3, 3)
    """
    v = vector_of(v)
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    zero = jnp.zeros_like(x)
    return stack_matrix([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def stack_matrix(rows: list[list[jax.Array]]) -> jax.Array:
    """Assemble (..., n, m) from nested lists of its entries, each of shape (...)."""
    return jnp.stack([jnp.stack(row, axis=-1) for row in rows], axis=-2)


@compiled_whole
def matvec(matrix: ArrayLike, v: ArrayLike) -> jax.Array:
    """Matrix times vector, (..., n, m) by (..., m), over broadcast leading axes."""
    matrix, v = floating(matrix), floating(v)
    batch = jnp.broadcast_shapes(matrix.shape[:-2], v.shape[:-1])
    matrix = jnp.broadcast_to(matrix, batch + matrix.shape[-2:])
    v = jnp.broadcast_to(v, batch + v.shape[-1:])
    # A sum of products keeps full precision on devices whose matrix units round their inputs.
    return jnp.sum(matrix * v[..., None, :], axis=-1)


@compiled_whole
def norm(v: ArrayLike) -> jax.Array:
    """Euclidean norm over the last axis, shape (...); its gradient at v = 0 is zero."""
    v = floating(v)
    squared = jnp.sum(v * v, axis=-1)
    vanishes = squared < tiny(v)
    return jnp.where(vanishes, 0.0, jnp.sqrt(jnp.where(vanishes, 1.0, squared)))


def inverse(matrix: ArrayLike) -> jax.Array:
    """Inverse of a 3 x 3 matrix, (3, 3), by cofactors.

    No factorisation: inside a loop that is many times faster than a call of LAPACK.
    """
    matrix = jnp.asarray(matrix)
    a, b, c = matrix
    columns = jnp.stack([jnp.cross(b, c), jnp.cross(c, a), jnp.cross(a, b)], axis=-1)
    return columns / jnp.dot(a, columns[:, 0])
