"""What a state of the programme means: momentum, rate, wheel speeds, in components."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.interval import Course
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.turn import added, times
from jaxatt.simulation.momentum_model import Components, matvec, to_body
from jaxatt.spacecraft.wheel_motor import friction


class Controls(NamedTuple):
    """Controls of an interval.

    scaled : (n,), torques on the wheels over their limits.  powers : (m,), magnitudes of the
    wheels' power over `power_scale`.  dipoles : (6,) or none, positive and negative parts over the
    limits.
    """

    scaled: Array
    powers: Array
    dipoles: Array


def split(u: Array, form: WheelsForm) -> Controls:
    """Split the controls of an interval."""
    torques, powers = form.wheels, form.wheels + form.powers
    return Controls(u[:torques], u[torques:powers], u[powers:])


def product(matrix: Array, vector: Array) -> Array:
    """Product of a matrix (r, c) and a vector (c,), without a matrix product for every start."""
    total = matrix[:, 0] * vector[0]
    for k in range(1, vector.shape[0]):
        total = total + matrix[:, k] * vector[k]
    return total


def parts(vector: Array) -> Components:
    """The three components of a vector (3,)."""
    return vector[0], vector[1], vector[2]


def quaternion(x: Array) -> Components:
    """Attitude of a state."""
    return x[0], x[1], x[2], x[3]


def stored(x: Array, form: WheelsForm) -> Array:
    """Coordinates of the wheels' momentum, (k,)."""
    return x[4 : 4 + form.stored]


def total_momentum(x: Array, p: WheelsParameters, form: WheelsForm) -> Components:
    """Total momentum in inertial axes [N m s]."""
    if form.momentum == "zero":
        none = jnp.zeros_like(x[0])
        return none, none, none
    if not form.torqued:
        return parts(p.total)
    first = 4 + form.stored
    return times(p.momentum_scale, parts(x[first : first + 3]))


def lost_rate(x: Array, p: WheelsParameters, form: WheelsForm) -> Components:
    """Rate that the wheels have taken from the body, J_s^-1 A s [rad/s]."""
    return parts(product(p.to_rate, stored(x, form)))


def rate_of(x: Array, momentum: Components, p: WheelsParameters, form: WheelsForm) -> Components:
    """Rate omega_ib [rad/s] in body axes, of the total momentum in body axes."""
    return added(matvec(p.inverse, momentum), times(-1.0, lost_rate(x, p, form)))


def rate(x: Array, p: WheelsParameters, form: WheelsForm) -> Components:
    """Rate omega_ib [rad/s] in body axes."""
    lost = times(-1.0, lost_rate(x, p, form))
    if form.momentum == "zero":
        return lost
    return rate_of(x, to_body(quaternion(x), total_momentum(x, p, form)), p, form)


def course(x: Array, u: Array, p: WheelsParameters, form: WheelsForm) -> Course:
    """Body at the beginning of an interval, and what the controls do."""
    q, controls = quaternion(x), split(u, form)
    total = total_momentum(x, p, form)
    slope = product(p.to_rate, product(p.to_stored, controls.scaled))
    return Course(
        q,
        total if form.momentum == "zero" else to_body(q, total),
        lost_rate(x, p, form),
        parts(slope),
        dipole(controls, p, form),
    )


def dipole(controls: Controls, p: WheelsParameters, form: WheelsForm) -> Components:
    """Dipole [A m^2] that the optimiser decides; zero where it does not."""
    if form.magnetorquers != "decided":
        none = jnp.zeros_like(controls.scaled[0])
        return none, none, none
    return parts(p.dipole_limit * (controls.dipoles[:3] - controls.dipoles[3:]))


def wheel_power(
    y: Array, omega: Components, scaled: Array, p: WheelsParameters, form: WheelsForm
) -> Array:
    """Mechanical power of the wheels (c,) over `power_scale`.

    One sum over body axes, (A tau) . (A omega_bw), or tau_i omega_bw,i of every wheel, tau the
    torque of the motors.  y : (k,), coordinates of the wheels' momentum.
    """
    torque = motor_torque(y, omega, scaled, p, form)
    spins = wheel_speeds(y, omega, p, form)
    if form.power == "body":
        pushed = product(p.axes, torque)
        return jnp.sum(pushed * spins, keepdims=True) / p.power_scale
    return torque * spins / p.power_scale


def motor_torque(
    y: Array, omega: Components, scaled: Array, p: WheelsParameters, form: WheelsForm
) -> Array:
    """Torque (n,) [N m] of the motors: what accelerates the wheels and what friction takes."""
    if form.rubbing:
        scaled = scaled + jnp.asarray(friction(p.motors, own_speeds(y, omega, p)))
    return p.torque_limit * scaled


def own_speeds(y: Array, omega: Components, p: WheelsParameters) -> Array:
    """Speed (n,) [rad/s] of every wheel, where each one's momentum is carried."""
    return p.momentum_scale * y / p.wheel_inertia - product(p.axes.T, jnp.stack(omega))


def wheel_speeds(y: Array, omega: Components, p: WheelsParameters, form: WheelsForm) -> Array:
    """Wheel speeds [rad/s]: of every wheel (n,), or for `power` "body" their sum A omega_bw (3,).

    Where only the sum of the momenta is carried, all wheels have the same inertia.
    """
    if form.each:
        speeds = own_speeds(y, omega, p)
        return product(p.axes, speeds) if form.power == "body" else speeds
    summed = product(p.without_spin, y) / p.wheel_inertia[0]
    return summed - product(p.axes, product(p.axes.T, jnp.stack(omega)))


def kinetic_energy(x: Array, omega: Array, p: WheelsParameters, form: WheelsForm) -> Array:
    """Kinetic energy [J] of body and wheels.

    Where only the sum of the wheels' momenta is carried, the least one with that sum, of wheels of
    one inertia: torques spread without waste keep to it.
    """
    y = stored(x, form)
    body = 0.5 * jnp.sum(omega * product(p.without_spin, omega))
    if form.each:
        return body + 0.5 * jnp.sum((p.momentum_scale * y) ** 2 / p.wheel_inertia)
    summed = product(p.without_spin, y)
    return body + 0.5 * jnp.sum(summed * product(p.spread, summed)) / p.wheel_inertia[0]
