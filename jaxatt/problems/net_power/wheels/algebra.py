"""Small products and charts that the derivatives of an interval are made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
from jax import Array

from jaxatt.simulation.momentum_model import Components

Matrix3 = list[list[Array]]


def chart(s: Components) -> Matrix3:
    """Derivative (3, 3) of four times MRP s with respect to a small turn in body axes."""
    squared = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    across = skew(s)
    return [
        [(1.0 - squared) * (i == j) + 2.0 * across[i][j] + 2.0 * s[i] * s[j] for j in range(3)]
        for i in range(3)
    ]


def back(q: Components) -> Matrix3:
    """Rotation matrix R(q)'."""
    w, x, y, z = q
    return [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]


def conjugate(q: Components) -> Components:
    return q[0], -q[1], -q[2], -q[3]


def symmetric_product(left: Sequence[Array], right: Sequence[Array]) -> Array:
    """Sum of the products of the rows of both sides, and its transpose, (z, z).

    left, right : stacks (r, z) of rows.  One product of matrices, which XLA does not take apart:
    from sums of rank-one products it makes one loop that computes all rows again for every entry.
    Each stack is turned by itself: the transpose of the whole would become part of the product,
    which is then several times slower.
    """
    half = jnp.concatenate([rows.T for rows in left], axis=1) @ jnp.concatenate(right)
    return half + half.T


def times_rows(matrix: Array | Matrix3, rows: Components) -> Components:
    """Product of a matrix (3, 3) with three rows."""
    return tuple(m[0] * rows[0] + m[1] * rows[1] + m[2] * rows[2] for m in matrix)


def stacked(matrix: Matrix3) -> Array:
    """Array (r, c) of a matrix in scalars, put together in one go."""
    return jnp.stack([entry for row in matrix for entry in row]).reshape(len(matrix), -1)


def inverse(value: Array) -> Array:
    """Inverse, or 0 of an interval without length."""
    there = value > 0.0
    return jnp.where(there, 1.0 / jnp.where(there, value, 1.0), 0.0)


def dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def matrix_product(a: Array, b: Array) -> Array:
    """Product of small matrices as a sum of rank-one products."""
    total = a[:, :1] * b[:1]
    for k in range(1, a.shape[1]):
        total = total + a[:, k : k + 1] * b[k : k + 1]
    return total


def skew(v: Components) -> Matrix3:
    """Matrix of v x, in scalars."""
    none = jnp.zeros_like(v[0])
    return [[none, -v[2], v[1]], [v[2], none, -v[0]], [-v[1], v[0], none]]


def combined(*terms: tuple[Array | float, Matrix3]) -> Matrix3:
    """Sum of factors times matrices in scalars."""
    return [
        [sum((factor * m[i][j] for factor, m in terms), jnp.zeros(())) for j in range(3)]
        for i in range(3)
    ]


def composed(a: Matrix3, b: Matrix3) -> Matrix3:
    """Product of two matrices in scalars."""
    return [
        [a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j] for j in range(3)]
        for i in range(3)
    ]
