"""Path inequalities of an interval, the wheels' power and the battery, to second order."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.algebra import symmetric_product
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows


def margins(
    rows: Rows,
    x: Array,
    controls: at.Controls,
    h: Array,
    rates: Array,
    by_rates: Array,
    p: WheelsParameters,
) -> tuple[Array, Array, Array]:
    """Path inequalities, their slopes, and the slopes of the wheel speeds in them.

    rates : (6,) [rad/s], omega_ib at the beginning and at the end.  by_rates : (6, z), by z.
    """
    form = rows.form
    values, slopes = [], []
    spins = jnp.zeros((0, rows.width))
    if form.powers:
        power, by_power, spins = _powers(rows, x, controls, h, rates, by_rates, p)
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
    if not values:
        return jnp.zeros(0), jnp.zeros((0, rows.width)), spins
    return jnp.stack(values), jnp.stack(slopes), spins


def _powers(
    rows: Rows,
    x: Array,
    controls: at.Controls,
    h: Array,
    rates: Array,
    by_rates: Array,
    p: WheelsParameters,
) -> tuple[Array, list[Array], Array]:
    """Powers (m,) over `power_scale` at both ends, their slopes, and those of the wheel speeds."""
    form = rows.form
    each, own = jnp.eye(form.wheels), jnp.eye(form.stored)
    torque = p.torque_limit * controls.scaled
    pushed = at.product(p.axes, torque)
    powers, by_power, spins = [], [], []
    for late in range(2):
        part = late * h
        y = at.stored(x, form) + part * at.product(p.to_stored, controls.scaled)
        omega, by_omega = (both[3 * late : 3 * late + 3] for both in (rates, by_rates))
        speeds = at.wheel_speeds(y, at.parts(omega), p, form)
        by_y = jnp.stack(
            [rows.row(stored=own[i], torques=part * p.to_stored[i]) for i in range(form.stored)]
        )
        by_z = jax.vmap(
            lambda dy, dw: at.wheel_speeds(dy, at.parts(dw), p, form), in_axes=1, out_axes=1
        )(by_y, by_omega)
        spins.append(by_z)
        powers.append(at.wheel_power(y, at.parts(omega), controls.scaled, p, form))
        if form.power == "body":
            by = pushed[0] * by_z[0] + pushed[1] * by_z[1] + pushed[2] * by_z[2]
            direct = at.product(p.axes.T, speeds) * p.torque_limit
            by_power.append((by + rows.row(torques=direct)) / p.power_scale)
            continue
        for i in range(form.wheels):
            direct = p.torque_limit[i] * speeds[i] * each[i]
            by = torque[i] * by_z[i] + rows.row(torques=direct)
            by_power.append(by / p.power_scale)
    return jnp.concatenate(powers), by_power, jnp.concatenate(spins)


def path_hessian(
    rows: Rows, x: Array, u: Array, stage: WheelStage, p: WheelsParameters, dual: Array, kept: Any
) -> Array:
    """See `OptimalControlProgram.path_hessian`: of the wheels' power.

    That is bilinear in torques and speeds; what bends the speeds themselves, the torque times the
    second derivatives of the rates, is left out.
    """
    form = rows.form
    if not form.powers:
        return jnp.zeros((rows.width, rows.width))
    weight = [
        (dual[2 * i + 1] * p.returned - dual[2 * i] * p.taken) / p.power_scale
        for i in range(form.powers)
    ]
    if form.power == "body":
        pushed = [rows.row(torques=p.axes[k] * p.torque_limit) for k in range(3)]
        felt = [weight[0] * kept.spins[k] + weight[1] * kept.spins[3 + k] for k in range(3)]
    else:
        own, n = jnp.eye(form.wheels), form.wheels
        pushed = [rows.row(torques=own[k] * p.torque_limit[k]) for k in range(n)]
        felt = [weight[k] * kept.spins[k] + weight[n + k] * kept.spins[n + k] for k in range(n)]
    return symmetric_product([jnp.stack(pushed)], [jnp.stack(felt)])
