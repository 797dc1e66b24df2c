"""Solve small positive definite systems elementwise over the batch.

Under `jax.vmap` every Gauss-Jordan step is one operation on whole arrays, which for so few unknowns
is much faster than a LAPACK call for each member of the batch.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array


def solve_spd(matrix: Array, rhs: Array, added: Array | None = None) -> Array:
    """Solve an (m, m) positive definite system for (m,), by components and without pivots.

    added : (m,), what the diagonal has besides.
    """
    size = len(rhs)
    left = [[matrix[i, j] for j in range(i + 1)] for i in range(size)]
    if added is not None:
        for k in range(size):
            left[k][k] = left[k][k] + added[k]
    found = [rhs[i] for i in range(size)]
    for k in range(size):
        pivot = 1.0 / left[k][k]
        below = [left[i][k] for i in range(k + 1, size)]
        shares = [x * pivot for x in below]
        for i, share in zip(range(k + 1, size), shares, strict=True):
            for j in range(k + 1, i + 1):
                left[i][j] = left[i][j] - share * below[j - k - 1]
            found[i] = found[i] - share * found[k]
            left[i][k] = share
        left[k][k] = pivot
    for k in reversed(range(size)):
        found[k] = found[k] * left[k][k]
        for i in range(k + 1, size):
            found[k] = found[k] - left[i][k] * found[i]
    return jnp.stack(found)


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
