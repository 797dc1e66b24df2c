"""Continuous proportional-derivative law for a constant reference."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.vectors import matvec
from jaxatt.control.departure import departure
from jaxatt.control.proportional_derivative import proportional_derivative
from jaxatt.environment.table import Environment
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class PDLaw:
    """PD law tau_b = K_d omega_e + K_p eps_e, given as torque on the wheels.

    craft : vehicle.  reference : (4,), target q_ob.  reference_rate : (3,) [rad/s], target
    omega_ob.  proportional, derivative : () [1/s^2], [1/s], gains in units of J_s (table 5.1).
    clipped : whether each wheel's torque is held within its limit (static).

    Source: Schaanning (2021), eq. (5.8).  It stabilises because the body receives -A tau_w; it
    is meant for continuous feedback and is unstable when sampled and held at 1.4 s.
    """

    craft: Spacecraft
    reference: Array
    reference_rate: Array
    proportional: Array | float = 3.0
    derivative: Array | float = 2.7
    clipped: bool = field(default=True, metadata={"static": True})

    def __call__(self, interval: Array, state: AttitudeState, environment: Environment) -> Array:
        """Wheel torques (n,) [N m] at one instant."""
        errors = departure(self.reference, self.reference_rate, state, environment)
        wanted = proportional_derivative(*errors, self.proportional, self.derivative)
        torque = matvec(self.craft.inertia_without_spin, wanted)
        wheel_torque = matvec(self.craft.wheels.allocation, torque)
        limit = jnp.asarray(self.craft.wheels.torque_limit)
        return jnp.clip(wheel_torque, -limit, limit) if self.clipped else wheel_torque
