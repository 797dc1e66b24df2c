"""PD law for on/off thrusters, whose valves are switched by Schmitt triggers."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.control.departure import departure
from jaxatt.control.proportional_derivative import proportional_derivative
from jaxatt.environment.table import Environment
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SchmittLaw:
    """PD law that opens a thruster when its torque demand exceeds `on` and shuts it below `off`.

    craft : vehicle with thrusters.  reference : (4,), target q_ob.  reference_rate : (3,) [rad/s].
    proportional, derivative : () [N m], [N m s].  on, off : () [N m].

    The baseline of Kristiansen and Gravdahl (2023), section 4, which gives no numbers; the
    defaults bring the ESEO satellite to rest within its 30 s.  Wheels stay still.
    """

    craft: Spacecraft
    reference: Array
    reference_rate: Array
    proportional: Array | float = 0.5
    derivative: Array | float = 2.3
    on: Array | float = 0.06
    off: Array | float = 0.02

    @property
    def shut(self) -> Array:
        """Memory at the start, (m,): all valves are shut."""
        return jnp.zeros(self.craft.thrusters.count, bool)

    def __call__(
        self, interval: Array, state: AttitudeState, environment: Environment, opened: Array
    ) -> tuple[Array, Array]:
        """Torques of wheels and thrusters (n + m,) [N m] to hold, and which valves are open."""
        errors = departure(self.reference, self.reference_rate, state, environment)
        wanted = -proportional_derivative(*errors, self.proportional, self.derivative)
        thrusters = self.craft.thrusters
        b = jnp.asarray(thrusters.distribution)
        demand = wanted @ b / jnp.sum(b**2, axis=0)
        opened = jnp.where(opened, demand > self.off, demand > self.on)
        thrust = jnp.where(opened, jnp.asarray(thrusters.torque_limit), 0.0)
        return jnp.concatenate([jnp.zeros(self.craft.wheels.count), thrust]), opened
