"""Proportional-derivative feedback, and the sampled law that uses it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import jax
from jax import Array

from jaxatt.attitude.components import Scalar, Vector, matvec
from jaxatt.control.feedback import Measured

_V = TypeVar("_V", Vector, Array)


def proportional_derivative(
    error: _V, rate_error: _V, proportional: Scalar, derivative: Scalar
) -> _V:
    """PD feedback K_p eps_e + K_d omega_e, of vectors in components or of arrays (3,)."""
    return rate_error * derivative + error * proportional


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ProportionalDerivative:
    """Sampled PD law with torque K_d omega_e + K_p eps_e.

    inertia : (3, 3) [kg m^2].  proportional : () [1/s^2] and derivative : () [1/s], in units of it.
    Source: Kristiansen (2023), eq. (11.36); Horri et al., eq. (13), with the opposite sign.
    """

    inertia: Array
    proportional: Array | float
    derivative: Array | float

    def initial(self) -> tuple[()]:
        """This law has no memory."""
        return ()

    def __call__(
        self, measured: Measured, memory: tuple[()], period: Scalar
    ) -> tuple[Vector, tuple[()]]:
        """Torque on the wheels in body axes [N m]."""
        wanted = proportional_derivative(
            measured.error.eps, measured.rate_error, self.proportional, self.derivative
        )
        return matvec(self.inertia, wanted), memory
