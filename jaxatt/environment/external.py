"""Sum of the external torques on a spacecraft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
from jax import Array

from jaxatt.attitude.components import Matrix, Quaternion, Scalar, Vector
from jaxatt.environment.aerodynamic_drag import Drag
from jaxatt.environment.eddy_currents import EddyCurrents
from jaxatt.environment.gravity_gradient import tidal_torque
from jaxatt.environment.residual_dipole import ResidualDipole
from jaxatt.environment.solar_radiation_pressure import SolarPressure


class Along(NamedTuple):
    """Environment at one instant, vectors in inertial axes; None where it is not needed.

    down : unit vector to the Earth's centre.  gradient : 3 mu / r^3 [1/s^2].
    air_speed : velocity relative to the air [m/s].  sun : unit vector to the sun.
    light : fraction of its disk that is seen.  field : magnetic flux density [T].
    disturbance : torque [N m] in body axes that depends on time only.
    """

    down: Vector | None = None
    gradient: Array | None = None
    air_speed: Vector | None = None
    sun: Vector | None = None
    light: Array | None = None
    field: Vector | None = None
    disturbance: Vector | None = None


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ExternalTorques:
    """The disturbing torques that act; None for one that does not.

    The gravity gradient acts wherever `Along` holds one.
    """

    drag: Drag | None = None
    solar_pressure: SolarPressure | None = None
    residual_dipole: ResidualDipole | None = None
    eddy_currents: EddyCurrents | None = None

    @property
    def magnetic(self) -> bool:
        """Whether any of the torques needs the magnetic field."""
        return self.residual_dipole is not None or self.eddy_currents is not None

    def total(
        self, q_ib: Quaternion, omega: Vector, along: Along, inertia: Matrix, dipole: Vector | None
    ) -> Vector:
        """Sum of the external torques [N m] in body axes.

        omega : omega_ib [rad/s].  inertia : [kg m^2].  dipole : [A m^2], of magnetorquers.
        """
        zero: Scalar = 0.0 * omega.x
        torque = Vector(zero, zero, zero)
        if along.disturbance is not None:
            torque = torque + along.disturbance
        if along.down is not None and along.gradient is not None:
            torque = torque + tidal_torque(q_ib.rotate_inverse(along.down), along.gradient, inertia)
        if self.drag is not None and along.air_speed is not None:
            torque = torque + self.drag.torque(q_ib.rotate_inverse(along.air_speed))
        if self.solar_pressure is not None and along.sun is not None and along.light is not None:
            sun = q_ib.rotate_inverse(along.sun)
            torque = torque + self.solar_pressure.torque(sun, along.light)
        if along.field is not None:
            field = q_ib.rotate_inverse(along.field)
            if self.residual_dipole is not None:
                torque = torque + self.residual_dipole.torque(field)
            if self.eddy_currents is not None:
                torque = torque + self.eddy_currents.torque(field, omega)
            if dipole is not None:
                torque = torque + dipole.cross(field)
        return torque
