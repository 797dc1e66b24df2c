"""Torque of aerodynamic drag on a body with one centre of pressure."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.attitude.components import Scalar, Vector


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Drag:
    """Aerodynamic properties of a body, and of the air around it.

    density : () [kg/m^3].  area : () [m^2].  coefficient : (), C_D.
    lever : (3,) [m], centre of pressure from the centre of mass, in body axes.
    rotation : () [rad/s], rate at which the atmosphere turns with the Earth; 0 for air at rest in
    inertial axes, as the source has it.
    """

    density: Array | float
    area: Array | float
    coefficient: Array | float
    lever: Array
    rotation: Array | float = 0.0

    def air_speed(self, position: Vector, velocity: Vector) -> Vector:
        """Velocity relative to the air [m/s], in inertial axes."""
        spin = Vector(0.0, 0.0, self.rotation)
        return velocity - spin.cross(position)

    def torque(self, air_speed: Vector) -> Vector:
        """Torque of drag [N m] in body axes.

        air_speed : velocity relative to the air [m/s], in body axes.
        Source: Kristiansen (2023), eqs. (11.11) and (11.12).
        """
        speed: Scalar = air_speed.norm()
        force = air_speed * (-0.5 * self.density * self.area * self.coefficient * speed)
        return Vector.of(self.lever).cross(force)
