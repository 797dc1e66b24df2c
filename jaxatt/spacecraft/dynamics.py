"""Equations of motion of a rigid body with wheels and thrusters, wheel speeds included."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.attitude.vectors import cross, inverse, matvec
from jaxatt.environment.table import Environment
from jaxatt.spacecraft.vehicle import Spacecraft, total_momentum


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class AttitudeState:
    """State of a spacecraft with n wheels; leading axes batch.

    q_ob : (..., 4), attitude of the body relative to the orbit frame.
    omega_ib : (..., 3) [rad/s], inertial rate in body axes.
    omega_bw : (..., n) [rad/s], wheel speeds relative to the body.
    """

    q_ob: Array
    omega_ib: Array
    omega_bw: Array


def relative_rate(state: AttitudeState, environment: Environment) -> Array:
    """Rate relative to the orbit, omega_ib - R(q_ob)' omega_io, (..., 3) [rad/s]; eq. (4.3)."""
    return state.omega_ib - quaternion.rotate_inverse(state.q_ob, environment.orbit_rate)


@jax.jit
def at_relative_rate(
    q_ob: Array, omega_ob: Array, omega_bw: Array, environment: Environment
) -> AttitudeState:
    """Make a state from a rate relative to the orbit frame; inverse of `relative_rate`."""
    omega_ib = omega_ob + quaternion.rotate_inverse(q_ob, environment.orbit_rate)
    return AttitudeState(q_ob, omega_ib, jnp.asarray(omega_bw))


def derivative(
    craft: Spacecraft, state: AttitudeState, torque: Array, environment: Environment
) -> AttitudeState:
    """Time derivative of a state.

    torque : (n + m,) [N m], on each of the n wheels, of which the body receives the negative, then
        of each of the m thrusters.
    Source: Schaanning (2021), eqs. (4.2), (4.11), (4.12), (4.20b) and (4.20d).  The rate relative
    to the orbit is algebraic (4.3): (4.20c) counts the transport term twice and is not used.
    Thrusters: Kristiansen and Gravdahl (2023), eq. (8c), whose left side lacks its dot.
    """
    wheels, count = craft.wheels, craft.wheels.count
    wheel_torque, thrust = torque[:count], torque[count:]
    inertia = jnp.asarray(craft.inertia)
    q = quaternion.normalize(state.q_ob)
    down = quaternion.rotate_inverse(q, jnp.asarray([0.0, 0.0, 1.0], q.dtype))
    external = environment.gradient * cross(down, matvec(inertia, down)) + environment.disturbance
    if craft.thrusters.count:
        external = external + matvec(craft.thrusters.distribution, thrust)
    momentum = total_momentum(craft, state.omega_ib, state.omega_bw)
    total = external - matvec(wheels.axes, wheel_torque) - cross(state.omega_ib, momentum)
    omega_rate = matvec(inverse(jnp.asarray(craft.inertia_without_spin)), total)
    unit = AttitudeState(q, state.omega_ib, state.omega_bw)
    return AttitudeState(
        quaternion.derivative(state.q_ob, relative_rate(unit, environment)),
        omega_rate,
        wheel_torque / wheels.inertia - matvec(jnp.asarray(wheels.axes).T, omega_rate),
    )
