"""Motors of reaction wheels: friction that they work against, and torque that falls with speed.

The motor's torque is what accelerates the wheel and what its friction takes.  Its limit is that of
a motor at a fixed voltage: whole up to one speed, from there falling on a line to nothing at
another, while it drives; braking, the voltage that the motor itself induces helps, and the limit is
whole.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.spacecraft.checks import Float64
from jaxatt.spacecraft.parts.wheel_motor import wheel_motors as wheel_motors
from jaxatt.spacecraft.pytrees import WheelMotors as WheelMotors

Array = jax.Array | Float64

FRICTION_WIDTH = 1.0
"""[rad/s] Speed at which three quarters of the dry friction act; its sign is smooth within."""


def friction(motors: WheelMotors, speeds: Array) -> Array:
    """Torque (..., n) [N m] that friction takes at speeds (..., n) [rad/s], of the speeds' sign."""
    library: Any = np if isinstance(speeds, np.ndarray) else jnp
    coulomb, viscous = (_beside(x, speeds) for x in (motors.coulomb, motors.viscous))
    found: Array = coulomb * library.tanh(speeds / FRICTION_WIDTH) + viscous * speeds
    return found


def friction_slopes(motors: WheelMotors, speeds: jax.Array) -> tuple[jax.Array, jax.Array]:
    """First and second derivatives of `friction` by the speed, (..., n) each."""
    coulomb, viscous = (jnp.asarray(_beside(x, speeds)) for x in (motors.coulomb, motors.viscous))
    sense = jnp.tanh(speeds / FRICTION_WIDTH)
    slope = coulomb / FRICTION_WIDTH * (1.0 - sense * sense)
    return slope + viscous, -2.0 / FRICTION_WIDTH * sense * slope


def _beside(values: Array, speeds: Array) -> Array:
    """Values (n,) with as many axes as speeds (..., n)."""
    return values.reshape((1,) * (speeds.ndim - 1) + values.shape)


def torque_range(motors: WheelMotors, speeds: Array) -> tuple[Array, Array]:
    """Least and most torque of motors at speeds (..., n), as shares of their whole torque."""
    library: Any = np if isinstance(speeds, np.ndarray) else jnp
    fall, full = (_beside(x, speeds) for x in (motors.torque_fall, motors.full_torque_speed))

    def most(along: Array) -> Array:
        left = 1.0 - fall * (along - full)
        found: Array = library.clip(left, 0.0, 1.0)
        return found

    return -most(-speeds), most(speeds)


def motor_margins(
    motors: WheelMotors, taken: jax.Array, speeds: jax.Array, limit: jax.Array
) -> tuple[jax.Array, ...]:
    """Distances of the motors' torque from its limits in both senses, whole and falling, (n,) each.

    All in shares of the whole torque.  taken : (n,), what accelerates the wheels; `motors` has its
    friction in such shares.  limit : (n,), the share of the torque that may be used.
    """
    torque = taken + jnp.asarray(friction(motors, speeds))
    fall, full = jnp.asarray(motors.torque_fall), jnp.asarray(motors.full_torque_speed)
    return (
        limit - torque,
        limit + torque,
        limit - fall * (speeds - full) - torque,
        limit - fall * (-speeds - full) + torque,
    )
