"""Powers that a satellite gains and spends at an instant, exact and in component scalars."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Vector
from jaxatt.spacecraft.actuation_power import magnetorquer_power, wheel_power
from jaxatt.spacecraft.panels import collecting_area
from jaxatt.spacecraft.vehicle import Spacecraft
from jaxatt.spacecraft.wheel_motor import friction

_LOSSLESS = 1.0


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Powers:
    """What the battery of a vehicle receives and gives, its efficiencies included.

    irradiance : () [W/m^2].  wheel_power : static, a model of `actuation_power.wheel_power`.
    """

    craft: Spacecraft
    irradiance: Array | float
    wheel_power: str = field(default="wheels", metadata={"static": True})

    @property
    def _input(self) -> Any:
        battery = self.craft.battery
        return _LOSSLESS if battery is None else battery.input_efficiency

    @property
    def _output(self) -> Any:
        battery = self.craft.battery
        return _LOSSLESS if battery is None else battery.output_efficiency

    def solar(self, sun_b: Vector) -> Array:
        """Power [W] of the panels in full light; sun_b : unit vector to the sun in body axes."""
        if self.craft.panels is None:
            return jnp.zeros_like(sun_b.x)
        received: Array = self._input * self.irradiance * collecting_area(self.craft.panels, sun_b)
        return received

    def wheels(self, torque: tuple[Array, ...], speeds: tuple[Array, ...]) -> Array:
        """Power [W] of the wheels; torque [N m] and speed [rad/s] of each, (n,) of any shape.

        Their motors give what friction takes, too.
        """
        wheels, turning = self.craft.wheels, _last(speeds, speeds)
        motors = _last(torque, speeds) + friction(wheels.motors, turning)
        given: Array = wheel_power(wheels, motors, turning, self.wheel_power) / self._output
        return given

    def magnetorquers(self, dipole: Vector) -> Array:
        """Power [W] of the magnetorquers; dipole : [A m^2]."""
        if self.craft.magnetorquers is None:
            return jnp.zeros_like(dipole.x)
        given: Array = magnetorquer_power(self.craft.magnetorquers, dipole.array) / self._output
        return given


def _last(parts: tuple[Array, ...], like: tuple[Array, ...]) -> Array:
    """Scalars of the wheels as an array with the wheels last."""
    return jnp.stack([jnp.broadcast_to(x, y.shape) for x, y in zip(parts, like, strict=True)], -1)
