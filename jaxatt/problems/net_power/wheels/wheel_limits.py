"""Limits of the wheels' speeds and of their motors' torque, to second order.

Speeds are held to their range at the end of every interval: the first ones nothing changes.  The
torque of an interval is held to what the motor gives at its beginning and at its end.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.algebra import dot, stacked, symmetric_product
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.simulation.momentum_model import Components, matvec, to_body
from jaxatt.spacecraft.wheel_motor import friction_slopes, motor_margins


class Turning(NamedTuple):
    """Wheels at the beginning and at the end of an interval.

    speeds : (2, n) [rad/s], and by_z : (2, n, z), their slopes.
    """

    speeds: Array
    by_z: Array


def limit_rows(speeds: Array, scaled: Array, p: WheelsParameters, form: WheelsForm) -> list[Array]:
    """Distances of the wheels from their limits, (n,) each; speeds : (2, n) [rad/s]."""
    rows: list[Array] = []
    if form.speed_limited:
        rows += [
            jnp.sign(p.speed_upper) - speeds[1] / jnp.abs(p.speed_upper),
            speeds[1] / jnp.abs(p.speed_lower) - jnp.sign(p.speed_lower),
        ]
    if form.motor_limited:
        for each in speeds:
            rows += motor_margins(p.motors, scaled, each, p.motor_limit)
    return rows


def limit_slopes(rows: Rows, turning: Turning, p: WheelsParameters) -> list[Array]:
    """Slopes (n, z) of `limit_rows`."""
    form, found = rows.form, []
    by_z = turning.by_z
    if form.speed_limited:
        found += [
            -by_z[1] / jnp.abs(p.speed_upper)[:, None],
            by_z[1] / jnp.abs(p.speed_lower)[:, None],
        ]
    if form.motor_limited:
        torques = rows.block(torques=jnp.eye(form.wheels))
        falls = jnp.asarray(p.motors.torque_fall)[:, None]
        for speeds, spins in zip(turning.speeds, by_z, strict=True):
            given = torques + friction_slopes(p.motors, speeds)[0][:, None] * spins
            found += [-given, given, -falls * spins - given, falls * spins + given]
    return found


def limits_hessian(
    rows: Rows, x: Array, turning: Turning, back: Array, dual: Array, p: WheelsParameters
) -> Array:
    """Hessian (z, z) of dual . `limit_rows`.

    What bends is the friction, and the speed of a wheel on a body that turns with momentum; of the
    latter the turn before the interval is counted, not that within it.

    back : (3, 3), rotation from the body axes at the beginning to those at the end.
    dual : (r n,), of all rows.
    """
    form = rows.form
    weights = jnp.zeros((2, form.wheels))
    duals = list(dual.reshape(-1, form.wheels))
    left: list[Array] = []
    right: list[Array] = []
    if form.speed_limited:
        over, under = duals.pop(0), duals.pop(0)
        felt = under / jnp.abs(p.speed_lower) - over / jnp.abs(p.speed_upper)
        weights = weights.at[1].add(felt)
    if form.motor_limited:
        for end in range(2):
            most, least, driven, reverse = (duals.pop(0) for _ in range(4))
            slope, bend = friction_slopes(p.motors, turning.speeds[end])
            pressed, falling = least - most + reverse - driven, reverse - driven
            weights = weights.at[end].add(pressed * slope + falling * p.motors.torque_fall)
            left.append(turning.by_z[end])
            right.append((0.5 * pressed * bend)[:, None] * turning.by_z[end])
    if form.momentum != "zero":
        total = to_body(at.quaternion(x), at.total_momentum(x, p, form))
        pull = _seen(weights, back, p)
        level = dot(pull, total)
        facing = [
            [
                0.25 * (pull[i] * total[j] + total[i] * pull[j]) - 0.5 * level * (i == j)
                for j in range(3)
            ]
            for i in range(3)
        ]
        left.append(rows.turn)
        right.append(rows.block(turn=0.25 * stacked(facing)))
    if not left:
        return jnp.zeros((rows.width, rows.width))
    return symmetric_product(left, right)


def _seen(weights: Array, back: Array, p: WheelsParameters) -> Components:
    """What weighs a change of the momentum at the beginning, of weights (2, n) of wheel speeds."""
    first, last = (matvec(p.inverse, at.parts(-at.product(p.axes, each))) for each in weights)
    turned = at.product(back.T, jnp.stack(last))
    return tuple(first[i] + turned[i] for i in range(3))
