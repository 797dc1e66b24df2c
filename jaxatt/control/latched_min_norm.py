"""Gain-scheduled min-norm law that switches once from low to high gains and stays there."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.control.feedback import Measured
from jaxatt.control.min_norm import benchmark, direction, projected


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class LatchedMinNorm:
    """Low gains until the torque has once been off, high gains from then on.

    inertia : (3, 3) [kg m^2].  proportional, derivative : (2,), low ones first, in units of it.
    coupling : () [1/s], gamma.  printed : whether LgV carries the inverse inertia (static).
    Source: Horri, Palmer and Roberts, eq. (22).  At rest (22) itself would choose the high gains;
    the text starts with the low ones, and so does this law.
    """

    inertia: Array
    proportional: Array
    derivative: Array
    coupling: Array | float
    printed: bool = field(default=False, metadata={"static": True})

    def initial(self) -> tuple[Array, Array]:
        """Memory: whether the torque has been off, and LgV u_2 at the previous sample."""
        return jnp.asarray(0.0), jnp.asarray(0.0)

    def __call__(
        self, measured: Measured, memory: tuple[Array, Array], period: Scalar
    ) -> tuple[Vector, tuple[Array, Array]]:
        """Torque on the wheels in body axes [N m], and the updated memory."""
        latch, before = memory
        along = direction(measured, self.coupling, self.inertia, self.printed)
        low, high = (
            benchmark(measured, self.inertia, self.proportional[i], self.derivative[i])
            for i in range(2)
        )
        now = jnp.asarray(along.dot(high))
        soon = 2.0 * now - before  # at the next sample
        change = jnp.where(now == soon, 1.0, now - soon)
        share = jnp.clip(now / change, 0.0, 1.0)  # of the period until the sign changes
        switches = (now < 0.0) != (soon < 0.0)
        on = jnp.where(now < 0.0, jnp.where(switches, share, 1.0), 0.0)
        latch = jnp.maximum(latch, jnp.where(now < 0.0, 0.0, 1.0))
        chosen = latch * high + (1.0 - latch) * low
        return -on * projected(chosen, along), (latch, now)
