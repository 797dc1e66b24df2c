"""Proportional-derivative attitude law."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import errors
from jaxatt.environment.table import Environment
from jaxatt.simulation.flight import Law
from jaxatt.spacecraft import dynamics
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft


def pd_law(
    craft: Spacecraft,
    reference: Array,
    reference_rate: Array,
    proportional: Array | float = 3.0,
    derivative: Array | float = 2.7,
    clipped: bool = True,
) -> Law:
    """Law tau_b = K_d omega_e + K_p eps_e of (5.8), as torque on the wheels.

    reference : (4,), target q_ob.  reference_rate : (3,) [rad/s], target omega_ob.
    proportional, derivative : () [1/s^2], [1/s], gains in units of J_s (table 5.1).
    clipped : whether each wheel's torque is held within its limit.
    Source: Schaanning (2021), eq. (5.8).  It stabilises because the body receives -A tau_w; it
    is meant for continuous feedback and is unstable when sampled and held at 1.4 s.
    """
    inertia = jnp.asarray(craft.inertia_without_spin)
    allocation = craft.wheels.allocation
    limit = jnp.asarray(craft.wheels.torque_limit)

    def law(interval: Array, state: AttitudeState, environment: Environment) -> Array:
        error = errors.error_quaternion(reference, state.q_ob)
        error = jnp.where(error[0] < 0.0, -error, error)
        rate_error = dynamics.relative_rate(state, environment) - reference_rate
        torque = inertia @ (derivative * rate_error + proportional * error[1:])
        wheel_torque = allocation @ torque
        return jnp.clip(wheel_torque, -limit, limit) if clipped else wheel_torque

    return law
