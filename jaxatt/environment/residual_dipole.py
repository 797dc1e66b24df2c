"""Torque of the spacecraft's residual magnetic dipole in the Earth's field."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.attitude.components import Vector


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ResidualDipole:
    """Residual magnetic dipole of a body.

    dipole : (3,) [A m^2], in body axes.
    """

    dipole: Array

    def torque(self, field: Vector) -> Vector:
        """Torque m x B [N m]; field : [T] in body axes.

        Source: Kristiansen (2023), eqs. (5.19) and (11.16).
        """
        return Vector.of(self.dipole).cross(field)
