"""Path inequalities of an interval, the wheels' power, the battery and limits, to second order."""

from __future__ import annotations

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
    """Both ends of an interval: coordinates y (k,) of the wheels' momentum and omega_ib (3,)
    [rad/s], their slopes (k, z) and (3, z), and the speeds of all wheels where they matter."""

    stored: tuple[Array, ...]
    rates: tuple[Array, ...]
    by_stored: tuple[Array, ...]
    by_rates: tuple[Array, ...]
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
    form = rows.form
    own = jnp.eye(form.stored)
    stored, by_stored = [], []
    for part in (0.0 * h, h):
        stored.append(at.stored(x, form) + part * at.product(p.to_stored, controls.scaled))
        by_stored.append(
            jnp.stack(
                [rows.row(stored=own[i], torques=part * p.to_stored[i]) for i in range(form.stored)]
            )
        )
    omega, by_omega = (rates[:3], rates[3:]), (by_rates[:3], by_rates[3:])
    speeds, by_z = jnp.zeros((2, 0)), jnp.zeros((2, 0, rows.width))
    if form.watched:
        pairs = tuple(zip(stored, omega, strict=True)), tuple(zip(by_stored, by_omega, strict=True))
        speeds = jnp.stack([at.own_speeds(y, at.parts(w), p) for y, w in pairs[0]])
        by_z = jnp.stack([_own_slopes(dy, dw, p) for dy, dw in pairs[1]])
    return Ends(tuple(stored), omega, tuple(by_stored), by_omega, Turning(speeds, by_z))


def _own_slopes(by_stored: Array, by_rate: Array, p: WheelsParameters) -> Array:
    def along(dy: Array, dw: Array) -> Array:
        return at.own_speeds(dy, at.parts(dw), p)

    return jax.vmap(along, in_axes=1, out_axes=1)(by_stored, by_rate)


def margins(
    rows: Rows, x: Array, controls: at.Controls, ends: Ends, p: WheelsParameters
) -> tuple[Array, Array, Array]:
    """Path inequalities, their slopes, and the slopes of the wheel speeds in those of power."""
    form = rows.form
    values, slopes = [], []
    spins = jnp.zeros((0, rows.width))
    if form.powers:
        power, by_power, spins = _powers(rows, controls, ends, p)
        which = jnp.eye(form.powers)
        for i in range(form.powers):
            paid = rows.row(powers=which[i])
            values += [
                controls.powers[i] - p.taken * power[i],
                controls.powers[i] + p.returned * power[i],
            ]
            slopes += [paid - p.taken * by_power[i], paid + p.returned * by_power[i]]
    if form.charge:
        values.append(x[-1] - p.floor)
        slopes.append(rows.row(charge=jnp.ones(1)))
    limits = limit_rows(ends.turning.speeds, controls.scaled, p, form)
    if not values and not limits:
        return jnp.zeros(0), jnp.zeros((0, rows.width)), spins
    stacked = ([jnp.stack(values)], [jnp.stack(slopes)]) if values else ([], [])
    return (
        jnp.concatenate([*stacked[0], *limits]),
        jnp.concatenate([*stacked[1], *limit_slopes(rows, ends.turning, p)]),
        spins,
    )


def _powers(
    rows: Rows, controls: at.Controls, ends: Ends, p: WheelsParameters
) -> tuple[Array, list[Array], Array]:
    """Powers (m,) over `power_scale` at both ends, their slopes, and those of the wheel speeds."""
    form = rows.form
    each = jnp.eye(form.wheels)
    powers, by_power, spins = [], [], []
    for end, (y, omega, by_y, by_omega) in enumerate(zip(*ends[:4], strict=True)):
        torque = at.motor_torque(y, at.parts(omega), controls.scaled, p, form)
        speeds = at.wheel_speeds(y, at.parts(omega), p, form)
        by_z = jax.vmap(
            lambda dy, dw: at.wheel_speeds(dy, at.parts(dw), p, form), in_axes=1, out_axes=1
        )(by_y, by_omega)
        spins.append(by_z)
        powers.append(at.wheel_power(y, at.parts(omega), controls.scaled, p, form))
        rubbed = jnp.zeros((form.wheels, 0))
        if form.rubbing:
            slope = p.torque_limit * friction_slopes(p.motors, ends.turning.speeds[end])[0]
            rubbed = (slope * met(speeds, p, form))[:, None] * ends.turning.by_z[end]
        if form.power == "body":
            pushed = at.product(p.axes, torque)
            by = pushed[0] * by_z[0] + pushed[1] * by_z[1] + pushed[2] * by_z[2]
            direct = met(speeds, p, form) * p.torque_limit
            by = by + rows.row(torques=direct)
            by_power.append((by + jnp.sum(rubbed, axis=0) if form.rubbing else by) / p.power_scale)
            continue
        for i in range(form.wheels):
            direct = p.torque_limit[i] * speeds[i] * each[i]
            by = torque[i] * by_z[i] + rows.row(torques=direct)
            by_power.append((by + rubbed[i] if form.rubbing else by) / p.power_scale)
    return jnp.concatenate(powers), by_power, jnp.concatenate(spins)


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
    n = form.wheels
    weight = [
        (dual[2 * i + 1] * p.returned - dual[2 * i] * p.taken) / p.power_scale
        for i in range(form.powers)
    ]
    if form.power == "body":
        pushed = [rows.row(torques=p.axes[k] * p.torque_limit) for k in range(3)]
        felt = [weight[0] * kept.spins[k] + weight[1] * kept.spins[3 + k] for k in range(3)]
    else:
        own = jnp.eye(n)
        pushed = [rows.row(torques=own[k] * p.torque_limit[k]) for k in range(n)]
        felt = [weight[k] * kept.spins[k] + weight[n + k] * kept.spins[n + k] for k in range(n)]
    left, right = [jnp.stack(pushed)], [jnp.stack(felt)]
    if form.rubbing:
        for end in range(2):
            speeds, by_z = kept.wheels.speeds[end], kept.wheels.by_z[end]
            slope, bend = (p.torque_limit * part for part in friction_slopes(p.motors, speeds))
            if form.power == "body":
                across = p.axes.T @ p.axes
                multiplied, faster = weight[end] * across @ speeds, weight[end] * across @ by_z
            else:
                share = jnp.stack(weight[end * n : end * n + n])
                multiplied, faster = share * speeds, share[:, None] * by_z
            left.append(by_z)
            right.append(slope[:, None] * faster + (0.5 * bend * multiplied)[:, None] * by_z)
    return symmetric_product(left, right)
