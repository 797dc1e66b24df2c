"""Gaussian elimination with row pivots, without LAPACK.

A KKT matrix is indefinite, so that it needs pivots.  Programs that call LAPACK cannot run side by
side, and some of XLA's options lose the call.

Source: Golub and Van Loan (2013), "Matrix Computations", algorithm 3.4.1.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax


class Factors(NamedTuple):
    """Triangular factors of a matrix with permuted rows.

    both : (n, n), the upper one, and below its diagonal the lower one, whose diagonal is 1.
    order : (n,), row of the matrix in each row of the factors.
    """

    both: Array
    order: Array


def factored(matrix: Array) -> Factors:
    """Factor a matrix (n, n)."""
    n = matrix.shape[0]
    rows = jnp.arange(n)

    def column(k: int, state: tuple[Array, Array]) -> tuple[Array, Array]:
        a, order = state
        pivot = jnp.argmax(jnp.where(rows >= k, jnp.abs(a[:, k]), -1.0))
        swapped = rows.at[k].set(pivot).at[pivot].set(k)
        a, order = a[swapped], order[swapped]
        share = jnp.where(rows > k, a[:, k] / a[k, k], 0.0)
        upper = jnp.where(rows > k, a[k], 0.0)
        a = a - share[:, None] * upper[None, :]
        return a.at[:, k].set(jnp.where(rows > k, share, a[:, k])), order

    return Factors(*lax.fori_loop(0, n, column, (matrix, rows)))


def solved(factors: Factors, right: Array) -> Array:
    """Solve for a right-hand side (n,)."""
    a, n = factors.both, right.shape[0]
    rows = jnp.arange(n)

    def down(k: int, x: Array) -> Array:
        return x - jnp.where(rows > k, a[:, k], 0.0) * x[k]

    def up(j: int, x: Array) -> Array:
        k = n - 1 - j
        x = x.at[k].divide(a[k, k])
        return x - jnp.where(rows < k, a[:, k], 0.0) * x[k]

    lower = lax.fori_loop(0, n, down, right[factors.order])
    return lax.fori_loop(0, n, up, lower)
