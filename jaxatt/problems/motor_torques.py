"""Torques that the motors of wheels must give in a flight, and whether they can.

What a plan decides is the torque that accelerates a wheel, and that the body receives; its motor
gives that and what friction takes.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.wheel_motor import WheelMotors, friction, torque_range
from jaxatt.spacecraft.wheels import ReactionWheels

_BEYOND = 1e-6
"""Share of its limit by which a motor's torque must be beyond it to count as beyond."""


def in_shares(wheels: ReactionWheels) -> WheelMotors:
    """Motors whose friction is in units of the torque limits."""
    motors, limit = wheels.motors, np.asarray(wheels.torque_limit)
    return WheelMotors(
        jnp.asarray(motors.coulomb / limit),
        jnp.asarray(motors.viscous / limit),
        jnp.asarray(motors.full_torque_speed),
        jnp.asarray(motors.torque_fall),
    )


def motor_torque(
    wheels: ReactionWheels, torque: Floats | Array, omega_bw: Floats | Array
) -> Floats:
    """Largest torque of each motor in each interval, with its sign, (..., N, n) [N m].

    torque : (..., N, n) [N m], held over each interval.  omega_bw : (..., N k + 1, n) [rad/s].
    """
    given = _at_both_ends(wheels, torque, omega_bw)[0]
    index = np.abs(given).argmax(axis=-2)[..., None, :]
    return np.asarray(np.take_along_axis(given, index, axis=-2)[..., 0, :])


def motor_excess(
    wheels: ReactionWheels, torque: Floats | Array, omega_bw: Floats | Array
) -> Floats:
    """Largest excess of each motor's torque over its limit, as a share of the whole, (S, n).

    Arguments as for `motor_torque`.  Negative where there is something to spare; -1 for motors
    without friction whose torque does not fall, which are judged by their torque alone.
    """
    shape = (len(np.asarray(omega_bw)), wheels.count)
    if wheels.motors.ideal:
        return np.full(shape, -1.0)
    given, speeds = _at_both_ends(wheels, torque, omega_bw)
    least, most = torque_range(wheels.motors, speeds)
    share = given / np.asarray(wheels.torque_limit)
    return np.asarray(np.maximum(share - most, least - share).max(axis=(1, 2)))


def broken_motors(
    wheels: ReactionWheels, torque: Floats | Array, omega_bw: Floats | Array
) -> list[str]:
    """Words on each motor that is asked for too much; torque (N, n), omega_bw (N k + 1, n)."""
    excess = motor_excess(wheels, np.asarray(torque)[None], np.asarray(omega_bw)[None])[0]
    return [
        f"the motor of {wheels.names[i]} is asked for {100.0 * excess[i]:.3g} % of its torque "
        "limit more than it gives at that speed, friction included"
        for i in np.flatnonzero(excess > _BEYOND)
    ]


def _at_both_ends(
    wheels: ReactionWheels, torque: Floats | Array, omega_bw: Floats | Array
) -> tuple[Floats, Floats]:
    """Motors' torques and speeds at both ends of all steps of each interval, (..., N, 2 k, n)."""
    held, speeds = np.asarray(torque, float), np.asarray(omega_bw, float)
    count = held.shape[-2]
    each = (speeds.shape[-2] - 1) // count
    ends = [
        part.reshape(*held.shape[:-2], count, each, wheels.count)
        for part in (speeds[..., :-1, :], speeds[..., 1:, :])
    ]
    both = np.concatenate(ends, axis=-2)
    return held[..., None, :] + np.asarray(friction(wheels.motors, both)), both
