"""Electrical power that wheels and magnetorquers draw."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from jaxatt.attitude.components import Scalar
from jaxatt.attitude.smooth_maximum import magnitude
from jaxatt.attitude.vectors import dot, matvec
from jaxatt.spacecraft.magnetorquers import Magnetorquers
from jaxatt.spacecraft.wheels import ReactionWheels

WHEEL_POWERS = ("signed", "body", "wheels")
"""Models of the wheels' power."""


def wheel_power(
    wheels: ReactionWheels, torque: Any, speed: Any, model: str, smoothing: Scalar = 0.0
) -> jax.Array:
    """Electrical power (...) [W] of the wheels.

    torque : (..., n) [N m], on each wheel; the body receives the negative.
    speed : (..., n) [rad/s], omega_bw.
    model : "signed", sum tau_i w_i / eta: braking returns all that driving costs, eq. (4.6), whose
        sign is turned to that of the torque of (4.9d);
        "body", |A tau . A w| / eta, eq. (5.7);
        "wheels", `drive_power` of each wheel by itself.
    smoothing : alpha [W^2] of the smooth maximum (2.11) for magnitudes; 0 is exact.
    Source: Kristiansen (2023).  Raises `ValueError` for an unknown model.
    """
    torque, speed = jnp.asarray(torque), jnp.asarray(speed)
    if model == "signed":
        return dot(torque, speed) / wheels.efficiency
    if model == "body":
        turned = dot(matvec(wheels.axes, torque), matvec(wheels.axes, speed))
        return magnitude(turned, smoothing) / wheels.efficiency
    if model == "wheels":
        return jnp.sum(drive_power(wheels, torque * speed, smoothing), axis=-1)
    raise ValueError(f"wheel power: {model!r} is no model; allowed: {', '.join(WHEEL_POWERS)}")


def drive_power(wheels: ReactionWheels, mechanical: Any, smoothing: Scalar = 0.0) -> jax.Array:
    """Electrical power [W] of one drive that gives its wheel a mechanical power tau w [W].

    mechanical : any shape; negative while the wheel brakes.  Driving costs p / eta and braking
    |p| `wheels.braking_cost`, which is the larger of p / eta and -p `wheels.braking_cost`.
    """
    driving, braking = 1.0 / wheels.efficiency, wheels.braking_cost
    even, odd = 0.5 * (driving + braking), 0.5 * (driving - braking)
    return even * magnitude(mechanical, smoothing) + odd * mechanical


def magnetorquer_power(
    magnetorquers: Magnetorquers, dipole: Any, smoothing: Scalar = 0.0
) -> jax.Array:
    """Electrical power (...) [W] of the magnetorquers; 0 where nothing is known of it.

    dipole : (..., 3) [A m^2].  smoothing : alpha [(A m^2)^2] of (2.11); 0 is exact.
    By full power, sum |m_i| / m_max,i of three axes times a third of it: Kristiansen (2023),
    eq. (5.6), which sums to infinity in print.  By coil resistance, sum R_i I_i^2 with the current
    I_i = m_i / (n_i A_i): eqs. (6.7) and (6.9).
    """
    dipole = jnp.asarray(dipole)
    if magnetorquers.full_power is not None:
        used = dot(magnitude(dipole, smoothing), 1.0 / jnp.asarray(magnetorquers.dipole_limit))
        return used * magnetorquers.full_power / 3.0
    return dot(dipole**2, magnetorquers.loss_coefficient)
