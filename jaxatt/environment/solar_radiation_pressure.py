"""Torque of solar radiation pressure on a body with one centre of pressure."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.attitude.components import Scalar, Vector


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SolarPressure:
    """Optical properties of a body, and of the light on it.

    irradiance : () [W/m^2].  light_speed : () [m/s].  area : () [m^2].  reflectance : ().
    lever : (3,) [m], centre of pressure from the centre of mass, in body axes.
    """

    irradiance: Array | float
    area: Array | float
    reflectance: Array | float
    lever: Array
    light_speed: Array | float = 299792458.0

    def torque(self, sun: Vector, light: Scalar) -> Vector:
        """Torque [N m] in body axes; the illuminated face is always normal to the light.

        sun : unit vector towards the sun, in body axes.  light : fraction of the sun's disk seen.
        Source: Kristiansen (2023), eqs. (11.14) and (11.15), where the force points along the
        inertial y axis whatever the date: the sun is then at -y.
        """
        pressure = self.irradiance / self.light_speed * self.area * (1.0 + self.reflectance)
        return Vector.of(self.lever).cross(sun * (-pressure * light))
