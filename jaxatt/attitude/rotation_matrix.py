"""Rotation matrices that are given: what they must be."""

import jax
import jax.numpy as jnp
import numpy as np
from jax.typing import ArrayLike

from jaxatt.attitude.vectors import sized

_LARGEST_DEVIATION = 0.05
"""Of a product of two columns from 0 or 1; entries rounded to two decimals deviate less."""


def rotation_of(matrix: ArrayLike) -> jax.Array:
    """Return a rotation matrix (..., 3, 3) as floating numbers.

    Where the numbers are known, a reflection or a matrix that is far from orthonormal raises
    `ValueError`; in compiled code, which raises nothing, a negative determinant gives NaN.
    """
    m = sized(matrix, 3, 3, name="rotation matrix")
    if isinstance(m, jax.core.Tracer):
        return jnp.where(_determinant(m)[..., None, None] > 0.0, m, jnp.nan)
    known = np.asarray(m)
    products = np.swapaxes(known, -1, -2) @ known
    if not (np.abs(products - np.eye(3)) <= _LARGEST_DEVIATION).all():
        raise ValueError(
            "rotation matrix: its columns are not three orthogonal unit vectors; give a rotation "
            "matrix without scale or shear"
        )
    if not (np.linalg.det(known) > 0.0).all():
        raise ValueError(
            "rotation matrix: its determinant is -1, so it is a reflection, which no attitude is; "
            "check the handedness of the axes or the sign of a row"
        )
    return m


def _determinant(m: jax.Array) -> jax.Array:
    return jnp.sum(m[..., 0, :] * jnp.cross(m[..., 1, :], m[..., 2, :]), axis=-1)
