"""Path inequalities of an interval, the wheels' power, the battery and limits, to second order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.algebra import symmetric_product
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.wheel_limits import (
    Turning,
    limit_rows,
    limit_slopes,
    limits_hessian,
)
from jaxatt.spacecraft.wheel_motor import friction_slopes


class Ends(NamedTuple):
    """Both ends of an interval: coordinates y (2, k) of the wheels' momentum and omega_ib (2, 3)
    [rad/s], their slopes (2, k, z) and (2, 3, z), and the speeds of all wheels where they
    matter."""

    stored: Array
    rates: Array
    by_stored: Array
    by_rates: Array
    turning: Turning


def ends_of(
    rows: Rows,
    x: Array,
    controls: at.Controls,
    h: Array,
    rates: Array,
    by_rates: Array,
    p: WheelsParameters,
) -> Ends:
    """Both ends of an interval of h [s].

    rates : (6,) [rad/s], omega_ib at the beginning and at the end.  by_rates : (6, z), by z.
    """

    def one(after: Array, rate: Array, by_rate: Array) -> Ends:
        y = at.stored(x, rows.form) + after * at.product(p.to_stored, controls.scaled)
        by_y = rows.stored + after * rows.driven(p)
        turning = Turning(jnp.zeros(0), jnp.zeros((0, rows.width)))
        if rows.form.watched:
            turning = Turning(
                at.own_speeds(y, at.parts(rate), p), _along_z(at.own_speeds, by_y, by_rate, p)
            )
        return Ends(y, rate, by_y, by_rate, turning)

    after = jnp.stack([jnp.zeros_like(h), h])
    return jax.vmap(one)(after, rates.reshape(2, 3), by_rates.reshape(2, 3, -1))


def _along_z(speeds: Callable[..., Array], by_y: Array, by_rate: Array, *given: Any) -> Array:
    """Slopes (r, z) of wheel speeds, which are linear in coordinates and rates."""
    return jax.vmap(lambda y, w: speeds(y, at.parts(w), *given), in_axes=1, out_axes=1)(
        by_y, by_rate
    )


def margins(
    rows: Rows, x: Array, controls: at.Controls, ends: Ends, p: WheelsParameters
) -> tuple[Array, Array, Array]:
    """Path inequalities, their slopes, and the slopes of the wheel speeds in those of power."""
    form = rows.form
    values, slopes = [], []
    spins = jnp.zeros((2, 0, rows.width))
    if form.powers:
        power, by_power, spins = jax.vmap(lambda end: _power(rows, controls, end, p))(ends)
        paid, power = rows.block(powers=jnp.eye(form.powers)), power.reshape(-1)
        by_power = by_power.reshape(-1, rows.width)

        def magnitude(price: Array) -> tuple[Array, Array]:
            return controls.powers + price * power, paid + price * by_power

        # Both rows of one power follow each other.
        value, slope = jax.vmap(magnitude, out_axes=1)(jnp.stack([-p.taken, p.returned]))
        values.append(value.reshape(-1))
        slopes.append(slope.reshape(-1, rows.width))
    if form.charge:
        values.append((x[-1] - p.floor)[None])
        slopes.append(rows.block(charge=jnp.ones((1, 1))))
    values += limit_rows(ends.turning.speeds, controls.scaled, p, form)
    slopes += limit_slopes(rows, ends.turning, p)
    if not values:
        return jnp.zeros(0), jnp.zeros((0, rows.width)), spins
    return jnp.concatenate(values), jnp.concatenate(slopes), spins


def _power(
    rows: Rows, controls: at.Controls, end: Ends, p: WheelsParameters
) -> tuple[Array, Array, Array]:
    """Powers (c,) over `power_scale` at one end, their slopes (c, z), and those of the wheel
    speeds (r, z)."""
    form, omega = rows.form, at.parts(end.rates)
    torque = at.motor_torque(end.stored, omega, controls.scaled, p, form)
    power = at.wheel_power(end.stored, omega, controls.scaled, p, form)
    speeds = met(at.wheel_speeds(end.stored, omega, p, form), p, form)
    spins = _along_z(at.wheel_speeds, end.by_stored, end.by_rates, p, form)
    # What accelerates a wheel, and what friction takes.
    by_torque = speeds[:, None] * rows.block(torques=jnp.diag(p.torque_limit))
    if form.rubbing:
        slope = p.torque_limit * friction_slopes(p.motors, end.turning.speeds)[0]
        by_torque = by_torque + (slope * speeds)[:, None] * end.turning.by_z
    if form.power == "body":
        pushed = at.product(p.axes, torque)
        by = jnp.sum(pushed[:, None] * spins, axis=0) + jnp.sum(by_torque, axis=0)
        return power, by[None] / p.power_scale, spins
    return power, (torque[:, None] * spins + by_torque) / p.power_scale, spins


def met(speeds: Array, p: WheelsParameters, form: WheelsForm) -> Array:
    """Speeds (n,) that the torque of each wheel is multiplied with; speeds : of `wheel_speeds`."""
    return at.product(p.axes.T, speeds) if form.power == "body" else speeds


def path_hessian(
    rows: Rows, x: Array, u: Array, stage: WheelStage, p: WheelsParameters, dual: Array, kept: Any
) -> Array:
    """See `OptimalControlProgram.path_hessian`: of the wheels' power and limits.

    Power is bilinear in torques and speeds; what bends the speeds themselves, the torque times the
    second derivatives of the rates, is left out of it.
    """
    form = rows.form
    turning: Turning = kept.wheels
    total = jnp.zeros((rows.width, rows.width))
    if form.powers:
        total = _bent_powers(rows, x, p, dual, kept)
    if form.speed_limited or form.motor_limited:
        first = 2 * form.powers + form.charge
        total = total + limits_hessian(rows, x, turning, kept.back, dual[first:], p)
    return total


def _bent_powers(rows: Rows, x: Array, p: WheelsParameters, dual: Array, kept: Any) -> Array:
    form = rows.form
    price = jnp.stack([-p.taken, p.returned]) / p.power_scale
    weight = jnp.reshape(at.product(dual[: 2 * form.powers].reshape(-1, 2), price), (2, -1))
    felt = weight[0][:, None] * kept.spins[0] + weight[1][:, None] * kept.spins[1]
    by_torque = jnp.diag(p.torque_limit)
    if form.power == "body":
        by_torque = p.axes @ by_torque
    left, right = [rows.block(torques=by_torque)], [felt]
    if form.rubbing:
        for end in range(2):
            speeds, by_z = kept.wheels.speeds[end], kept.wheels.by_z[end]
            slope, bend = (p.torque_limit * part for part in friction_slopes(p.motors, speeds))
            met_speeds, met_by_z = speeds, by_z
            if form.power == "body":
                across = p.axes.T @ p.axes
                met_speeds, met_by_z = across @ speeds, across @ by_z
            bent = 0.5 * bend * weight[end] * met_speeds
            left.append(by_z)
            right.append((slope * weight[end])[:, None] * met_by_z + bent[:, None] * by_z)
    return symmetric_product(left, right)
