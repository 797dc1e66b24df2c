"""Pointwise min-norm feedback law with a PD benchmark, and its gain-scheduled form."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar, Vector, matvec
from jaxatt.attitude.vectors import inverse
from jaxatt.control.feedback import Measured


def direction(measured: Measured, coupling: Scalar, inertia: Array, printed: bool) -> Vector:
    """Direction LgV' of a Lyapunov function with bilinear coupling; eq. (15)."""
    along = measured.rate_error + coupling * measured.error.eps
    return matvec(inverse(inertia), along) if printed else along


def benchmark(measured: Measured, inertia: Array, kp: Scalar, kd: Scalar) -> Vector:
    """Torque of the benchmark PD law on the body; eq. (13)."""
    return -matvec(inertia, kp * measured.error.eps + kd * measured.rate_error)


def projected(torque: Vector, along: Vector) -> Vector:
    """Smallest torque with the same LgV u as `torque`; eq. (10)."""
    squared = jnp.asarray(along.dot(along))
    vanishes = squared <= 0.0
    return along * (torque.dot(along) / jnp.where(vanishes, 1.0, squared))


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class MinNorm:
    """Smallest torque that decreases the Lyapunov function as fast as a PD law would.

    inertia : (3, 3) [kg m^2].  proportional, derivative : () [1/s^2], [1/s], in units of it.
    coupling : () [1/s], gamma.
    printed : whether LgV carries the inverse inertia (static), as the text has it; the published
    figures are those without.
    Source: Horri, Palmer and Roberts, eqs. (10) and (14), without the minus sign of (14).
    """

    inertia: Array
    proportional: Array | float
    derivative: Array | float
    coupling: Array | float
    printed: bool = field(default=False, metadata={"static": True})

    def initial(self) -> tuple[()]:
        """This law has no memory."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels in body axes [N m]."""
        along = direction(measured, self.coupling, self.inertia, self.printed)
        u = benchmark(measured, self.inertia, self.proportional, self.derivative)
        on = jnp.where(jnp.asarray(along.dot(u)) < 0.0, 1.0, 0.0)
        return -on * projected(u, along), memory


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class GainScheduledMinNorm:
    """Low gains while the high gains would need a large torque, then no torque, then high gains.

    As `MinNorm`, with gains of both modes (2,), low ones first.
    threshold : () [N m], epsilon: the high gains act where their torque is below it on every axis.
    Source: Horri, Palmer and Roberts, eq. (17).
    """

    inertia: Array
    proportional: Array
    derivative: Array
    coupling: Array | float
    threshold: Array | float
    printed: bool = field(default=False, metadata={"static": True})

    def initial(self) -> tuple[()]:
        """This law has no memory."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels in body axes [N m]."""
        along = direction(measured, self.coupling, self.inertia, self.printed)
        low, high = (
            benchmark(measured, self.inertia, self.proportional[i], self.derivative[i])
            for i in range(2)
        )
        on = jnp.where(jnp.asarray(along.dot(high)) < 0.0, 1.0, 0.0)
        near = jnp.where(high.largest() < self.threshold, 1.0, 0.0)
        chosen = near * high + (1.0 - near) * low
        return -on * projected(chosen, along), memory
