"""Torque of the eddy currents that the Earth's field induces in a rotating body."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.attitude.components import Vector


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class EddyCurrents:
    """Eddy-current property of a body.

    coefficient : () [m^4/ohm], k_eddy.
    """

    coefficient: Array | float

    def torque(self, field: Vector, omega: Vector) -> Vector:
        """Torque k (omega x B) x B [N m], which only takes energy out of the rotation.

        field : [T] and omega : omega_ib [rad/s], in body axes.
        Source: Kristiansen (2023), eq. (5.20): -k S(B) S(omega) B.
        """
        return omega.cross(field).cross(field) * self.coefficient
