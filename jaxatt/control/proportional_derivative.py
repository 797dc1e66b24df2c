"""Proportional-derivative law, sampled and held."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.attitude.components import Scalar, Vector, matvec
from jaxatt.control.feedback import Measured


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ProportionalDerivative:
    """Torque K_d omega_e + K_p eps_e.

    inertia : (3, 3) [kg m^2].  proportional : () [1/s^2] and derivative : () [1/s], in units of it.
    Source: Kristiansen (2023), eq. (11.36); Horri et al., eq. (13), with the opposite sign.
    """

    inertia: Array
    proportional: Array | float
    derivative: Array | float

    def initial(self) -> tuple[()]:
        """Nothing is remembered."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels."""
        wanted = self.derivative * measured.rate_error + self.proportional * measured.error.eps
        return matvec(self.inertia, wanted), memory
