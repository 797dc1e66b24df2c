"""First-order sliding-mode law."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.control.feedback import Measured
from jaxatt.control.surfaces import surface


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SlidingMode:
    """Sliding-mode law with torque k sgn(sigma) on each axis.

    gain : (3,) [N m].  slope : () [1/s] of the surface.  kind : "pointing" or "slewing" (static).
    Source: Kristiansen (2023), eq. (11.35).
    """

    gain: Array
    slope: Array | float
    kind: str = field(default="pointing", metadata={"static": True})

    def initial(self) -> tuple[()]:
        """This law has no memory."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels in body axes [N m]."""
        sigma = surface(self.kind, measured, self.slope)
        return Vector.of(self.gain).times(sigma.map(jnp.sign)), memory
