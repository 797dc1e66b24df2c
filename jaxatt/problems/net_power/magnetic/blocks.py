"""Matrices of three by three scalars, and the derivatives of an attitude in four MRP.

Every entry is a scalar of its own, which a batch turns into one contiguous vector; see
`jaxatt.attitude.components`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Matrix, Quaternion, Scalar, Vector

Rows = Sequence[Array]
"""Three rows of any length."""


def skew(v: Vector) -> Matrix:
    """Matrix of the vector product v x."""
    zero = 0.0 * v.x
    return Matrix((Vector(zero, -v.z, v.y), Vector(v.z, zero, -v.x), Vector(-v.y, v.x, zero)))


def outer(a: Vector, b: Vector) -> Matrix:
    """Matrix a b'."""
    return Matrix((a.x * b, a.y * b, a.z * b))


def identity(scale: Scalar) -> Matrix:
    """Scalar times the unit matrix."""
    zero = 0.0 * scale
    return Matrix((Vector(scale, zero, zero), Vector(zero, scale, zero), Vector(zero, zero, scale)))


def total(*matrices: Matrix) -> Matrix:
    """Sum of matrices."""
    first, *rest = matrices
    rows = list(first.rows)
    for other in rest:
        rows = [a + b for a, b in zip(rows, other.rows, strict=True)]
    return Matrix((rows[0], rows[1], rows[2]))


def scaled(a: Matrix, factor: Scalar) -> Matrix:
    """Matrix times a scalar."""
    return Matrix((a.rows[0] * factor, a.rows[1] * factor, a.rows[2] * factor))


def transposed(a: Matrix) -> Matrix:
    """Transpose of a matrix."""
    x, y, z = a.rows
    return Matrix((Vector(x.x, y.x, z.x), Vector(x.y, y.y, z.y), Vector(x.z, y.z, z.z)))


def times(a: Matrix, b: Matrix) -> Matrix:
    """Product of two matrices."""

    def row(of: Vector) -> Vector:
        x, y, z = b.rows
        return of.x * x + of.y * y + of.z * z

    return Matrix((row(a.rows[0]), row(a.rows[1]), row(a.rows[2])))


def crossed(v: Vector, a: Matrix) -> Matrix:
    """Product of the matrix of v x and another matrix."""
    x, y, z = a.rows
    return Matrix((v.y * z - v.z * y, v.z * x - v.x * z, v.x * y - v.y * x))


def on_rows(a: Matrix, rows: Rows) -> list[Array]:
    """Product of a matrix and three rows (n,); all may have the same axes more, behind."""
    return [along_rows(row, rows) for row in a.rows]


def along_rows(v: Vector, rows: Rows) -> Array:
    """Product v' and three rows (n,); all may have the same axes more, behind."""
    x, y, z = (jnp.asarray(part)[None] for part in v.parts)
    return x * rows[0] + y * rows[1] + z * rows[2]


class Turn(NamedTuple):
    """A turn of four MRP e, and its kinematics.

    sigma : MRP.  norm : () 1 + sigma' sigma.  rate : K, with de/dt = K omega.
    small : T = 1/K, the small turn in body axes that a change of e makes.
    """

    sigma: Vector
    norm: Scalar
    rate: Matrix
    small: Matrix

    @property
    def attitude(self) -> Quaternion:
        """Its unit quaternion."""
        scale = 1.0 / self.norm
        return Quaternion((2.0 - self.norm) * scale, (2.0 * scale) * self.sigma)


def turn(e: Vector) -> Turn:
    """Turn of four MRP e."""
    sigma = 0.25 * e
    norm = 1.0 + sigma.dot(sigma)
    rate = total(identity(2.0 - norm), skew(2.0 * sigma), outer(2.0 * sigma, sigma))
    return Turn(sigma, norm, rate, scaled(transposed(rate), 1.0 / (norm * norm)))


def rate_slope(at: Turn, n: Vector) -> Matrix:
    """Derivative of K n by e."""
    s = at.sigma
    along = identity(s.dot(n))
    return scaled(total(outer(s, n), outer(-n, s), skew(-n), along), 0.5)


def pulled_slope(at: Turn, n: Vector) -> Matrix:
    """Derivative of K' n by e."""
    s = at.sigma
    return scaled(total(outer(s, n), outer(-n, s), skew(n), identity(s.dot(n))), 0.5)


def small_slope(at: Turn, n: Vector) -> Matrix:
    """Derivative of T' n by e."""
    squared = 1.0 / (at.norm * at.norm)
    first = scaled(rate_slope(at, n), squared)
    return total(first, outer((at.rate @ n) * (-squared / at.norm), at.sigma))
