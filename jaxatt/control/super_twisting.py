"""Generalised super-twisting law: a second-order sliding mode with an integrated switching term."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.control.feedback import Measured
from jaxatt.control.surfaces import surface

_TINY = 1e-300


def _signed_root(x: Scalar) -> Array:
    """|x|^(1/2) sgn(x), with zero gradient at zero."""
    size = jnp.abs(x)
    return jnp.sign(x) * jnp.sqrt(jnp.where(size > 0.0, size, _TINY)) * (size > 0.0)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SuperTwisting:
    """Super-twisting law with torque k_1 phi_1(sigma) - z, dz/dt = -k_2 phi_2(sigma), on each axis.

    first : (3,), k_1.  second : (3,), k_2.  beta : ().  slope : () [1/s] of the surface.
    kind : "pointing" or "slewing" (static).
    Source: Kristiansen (2023), eq. (11.28), where |.|^x keeps the sign; z is integrated by Euler's
    method over the sampling period.
    """

    first: Array
    second: Array
    beta: Array | float
    slope: Array | float
    kind: str = field(default="pointing", metadata={"static": True})

    def initial(self) -> Vector:
        """Integral term z before the first sample: zero."""
        zero = 0.0 * jnp.asarray(self.first)
        return Vector.of(zero)

    def __call__(self, measured: Measured, memory: Vector, period: Scalar) -> tuple[Vector, Vector]:
        """Torque on the wheels in body axes [N m], and z at the next sample."""
        sigma = surface(self.kind, measured, self.slope)
        root = sigma.map(_signed_root)
        phi_1 = root + self.beta * sigma
        phi_2 = 0.5 * sigma.map(jnp.sign) + (1.5 * self.beta) * root + (self.beta**2) * sigma
        torque = Vector.of(self.first).times(phi_1) - memory
        return torque, memory - period * Vector.of(self.second).times(phi_2)
