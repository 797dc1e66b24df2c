"""Solve small positive definite systems elementwise over the batch.

Under `jax.vmap` every Gauss-Jordan step is one operation on whole arrays, which for so few unknowns
is much faster than a LAPACK call for each member of the batch.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array, lax


def solve_spd(matrix: Array, rhs: Array) -> Array:
    """Solve an (m, m) positive definite system for (m,)."""
    table = jnp.concatenate([matrix, rhs[:, None]], axis=1)

    def eliminate(k: Array, rows: Array) -> Array:
        pivot = lax.dynamic_index_in_dim(rows, k, keepdims=False)
        pivot = pivot / lax.dynamic_index_in_dim(pivot, k, keepdims=False)
        column = lax.dynamic_index_in_dim(rows, k, axis=1, keepdims=False)
        here = (jnp.arange(rows.shape[0]) == k)[:, None]
        return jnp.where(here, pivot[None], rows - column[:, None] * pivot[None])

    return lax.fori_loop(0, matrix.shape[0], eliminate, table)[:, -1]


def invert_spd_blocks(blocks: Array) -> Array:
    """Invert (N, b, b) positive definite blocks."""
    size = blocks.shape[-1]
    inverse = blocks
    for k in range(size):
        pivot = 1.0 / inverse[:, k, k]
        row = inverse[:, k, :] * pivot[:, None]
        column = inverse[:, :, k]
        inverse = inverse - column[:, :, None] * row[:, None, :]
        inverse = inverse.at[:, k, :].set(row)
        inverse = inverse.at[:, :, k].set(-column * pivot[:, None])
        inverse = inverse.at[:, k, k].set(pivot)
    return inverse
