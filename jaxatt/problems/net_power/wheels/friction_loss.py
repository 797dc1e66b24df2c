"""What friction takes where the wheels' power is signed, so that nothing else of it is lost.

The energy of wheels that turn faster or slower is a difference between the ends of a manoeuvre;
that of friction is summed up, by the trapezoidal rule, at both ends of every interval.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.wheel_limits import Turning
from jaxatt.spacecraft.wheel_motor import friction, friction_slopes


def friction_loss(speeds: Array, stage: WheelStage, p: WheelsParameters) -> Array:
    """Cost () of friction over an interval; speeds : (2, n) [rad/s], at both of its ends."""
    taken = jnp.asarray(friction(p.motors, speeds))
    return _price(stage, p) * jnp.sum(p.torque_limit[None] * taken * speeds)


def friction_loss_slope(turning: Turning, stage: WheelStage, p: WheelsParameters) -> Array:
    """Slope (z,) of `friction_loss`."""
    speeds = turning.speeds
    taken = jnp.asarray(friction(p.motors, speeds))
    by_speed = p.torque_limit[None] * (taken + friction_slopes(p.motors, speeds)[0] * speeds)
    return _price(stage, p) * jnp.sum(by_speed[..., None] * turning.by_z, axis=(0, 1))


def friction_loss_curvature(
    turning: Turning, stage: WheelStage, p: WheelsParameters
) -> tuple[Array, Array]:
    """Rows (2 n, z) and weighed rows whose product, with its transpose, is the Hessian.

    What bends the speeds themselves is left out.
    """
    slope, bend = friction_slopes(p.motors, turning.speeds)
    weight = p.torque_limit[None] * (slope + 0.5 * bend * turning.speeds)
    rows = turning.by_z.reshape(-1, turning.by_z.shape[-1])
    return rows, _price(stage, p) * weight.reshape(-1, 1) * rows


def _price(stage: WheelStage, p: WheelsParameters) -> Array:
    return 0.5 * stage.step * p.taken / p.energy_scale
