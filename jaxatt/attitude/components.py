"""Vectors and unit quaternions kept as separate scalars.

Inside a loop that is mapped over many runs every scalar becomes one contiguous batch vector.  On a
CPU that is three to four times faster than the same formulas on arrays of shape (3,), because
nothing is stacked and unstacked between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.vectors import quaternion_of, sized, vector_of

Scalar = Array | float


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Vector:
    """A vector of three components that share any shape, with the usual vector arithmetic."""

    x: Scalar
    y: Scalar
    z: Scalar

    @classmethod
    def of(cls, array: Any) -> Vector:
        """Make a vector from an array (..., 3)."""
        rows = vector_of(array)
        return cls(rows[..., 0], rows[..., 1], rows[..., 2])

    @property
    def array(self) -> Array:
        """Return the components as an array (..., 3)."""
        return jnp.stack([jnp.asarray(part) for part in self.parts], axis=-1)

    @property
    def parts(self) -> tuple[Scalar, Scalar, Scalar]:
        """The three components."""
        return self.x, self.y, self.z

    def map(self, function: Any, *others: Vector) -> Vector:
        """Apply `function` to each component, together with the same component of other vectors."""
        return Vector(*(function(*p) for p in zip(self.parts, *(o.parts for o in others))))  # noqa: B905

    def __add__(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y, self.z - other.z)

    def __mul__(self, factor: Scalar) -> Vector:
        return Vector(self.x * factor, self.y * factor, self.z * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor: Scalar) -> Vector:
        return self * (1.0 / divisor)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y, -self.z)

    def times(self, other: Vector) -> Vector:
        """Multiply component by component."""
        return Vector(self.x * other.x, self.y * other.y, self.z * other.z)

    def dot(self, other: Vector) -> Scalar:
        """Scalar product."""
        return self.x * other.x + self.y * other.y + self.z * other.z

    def cross(self, other: Vector) -> Vector:
        """Vector product self x other."""
        return Vector(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )

    def norm(self) -> Array:
        """Length; its gradient at zero is zero."""
        squared = jnp.asarray(self.dot(self))
        return jnp.where(squared > 0.0, jnp.sqrt(jnp.where(squared > 0.0, squared, 1.0)), 0.0)

    def largest(self) -> Array:
        """Largest absolute component."""
        return jnp.maximum(jnp.maximum(jnp.abs(self.x), jnp.abs(self.y)), jnp.abs(self.z))


def combination(vectors: Sequence[Vector], factors: Sequence[Scalar], like: Vector) -> Vector:
    """Sum vectors times factors; without any, return zero in the shape of `like`."""
    zero = 0.0 * like.x
    terms = (v * factor for v, factor in zip(vectors, factors, strict=True))
    return sum(terms, Vector(zero, zero, zero))


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Matrix:
    """A 3 x 3 matrix as three row vectors."""

    rows: tuple[Vector, Vector, Vector]

    @classmethod
    def of(cls, array: Any) -> Matrix:
        """Make a matrix from an array (..., 3, 3)."""
        matrix = sized(array, 3, 3, name="matrix")
        return cls(
            (
                Vector.of(matrix[..., 0, :]),
                Vector.of(matrix[..., 1, :]),
                Vector.of(matrix[..., 2, :]),
            )
        )

    def __matmul__(self, v: Vector) -> Vector:
        return Vector(*(row.dot(v) for row in self.rows))


def matvec(matrix: Array, v: Vector) -> Vector:
    """Product of a matrix (3, 3) and a vector."""
    return Matrix.of(matrix) @ v


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Quaternion:
    """A quaternion as scalar part and vector part, as in `jaxatt.attitude.quaternion`."""

    eta: Scalar
    eps: Vector

    @classmethod
    def of(cls, array: Any) -> Quaternion:
        """Make a quaternion from an array (..., 4), scalar first."""
        q = quaternion_of(array)
        return cls(q[..., 0], Vector.of(q[..., 1:]))

    @property
    def array(self) -> Array:
        """Return the quaternion as an array (..., 4), scalar first."""
        return jnp.concatenate([jnp.asarray(self.eta)[..., None], self.eps.array], axis=-1)

    def conjugate(self) -> Quaternion:
        """Conjugate; for a unit quaternion, its inverse."""
        return Quaternion(self.eta, -self.eps)

    def multiply(self, other: Quaternion) -> Quaternion:
        """Quaternion product, whose rotation is R(self) R(other)."""
        return Quaternion(
            self.eta * other.eta - self.eps.dot(other.eps),
            self.eta * other.eps + other.eta * self.eps + self.eps.cross(other.eps),
        )

    def rotate(self, v: Vector) -> Vector:
        """Rotate a vector: R(q) v."""
        twice = 2.0 * self.eps.cross(v)
        return v + self.eta * twice + self.eps.cross(twice)

    def rotate_inverse(self, v: Vector) -> Vector:
        """Rotate a vector back: R(q)' v."""
        return self.conjugate().rotate(v)

    def derivative(self, omega: Vector) -> Quaternion:
        """Kinematics dq/dt = 1/2 q (x) [0, omega], with omega in the axes that q turns from."""
        return Quaternion(
            -0.5 * self.eps.dot(omega), 0.5 * (self.eta * omega + self.eps.cross(omega))
        )

    def normalized(self) -> Quaternion:
        """Scale to unit norm."""
        scale = lax.rsqrt(jnp.asarray(self.eta * self.eta + self.eps.dot(self.eps)))
        return Quaternion(self.eta * scale, self.eps * scale)

    def canonical(self) -> Quaternion:
        """Of q and -q, which are the same attitude, return the one with eta >= 0."""
        sign = jnp.where(jnp.asarray(self.eta) < 0.0, -1.0, 1.0)
        return Quaternion(self.eta * sign, self.eps * sign)
