"""Attitude that aligns one body axis with a direction and constrains a second one."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax.typing import ArrayLike

from jaxatt.attitude import quaternion
from jaxatt.attitude.vectors import broadcast_batch, cross, norm

_PARALLEL = 1e-12
"""Sine of the angle below which two directions count as one."""


def align(
    body: ArrayLike, direction: ArrayLike, second_body: ArrayLike, second_direction: ArrayLike
) -> jax.Array:
    """Attitude in which a body axis points along a direction, and a second as near its own as can.

    Black's two-vector determination (1964, "TRIAD"): the plane of both body axes is laid onto the
    plane of both directions.

    Parameters
    ----------
    body, second_body : (..., 3)
        Axes in body components, of any length, not parallel.
    direction, second_direction : (..., 3)
        In the axes of reference, of any length, not parallel.

    Returns
    -------
    (..., 4)
        q, with R(q) from body to the axes of reference; in compiled code not a number where two are
        parallel, which raises `ValueError` elsewhere.
    """
    b, d, b2, d2 = broadcast_batch(body, direction, second_body, second_direction)
    return quaternion.from_matrix(_frame(d, d2) @ jnp.swapaxes(_frame(b, b2), -1, -2))


def _frame(first: jax.Array, second: jax.Array) -> jax.Array:
    """Columns (..., 3, 3): along the first, across both, and what completes them."""
    x, toward = first / norm(first)[..., None], second / norm(second)[..., None]
    across = cross(x, toward)
    size = norm(across)[..., None]
    y = across / jnp.where(size > _PARALLEL, size, jnp.nan)
    return jnp.stack([x, y, cross(x, y)], axis=-1)
