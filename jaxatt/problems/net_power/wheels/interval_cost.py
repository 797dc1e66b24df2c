"""Cost of an interval to first order, and the second order of its sunlight."""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.sunlight import by_turn, collected
from jaxatt.simulation.momentum_model import to_body


def interval_cost(
    rows: Rows,
    x: Array,
    controls: at.Controls,
    stage: WheelStage,
    p: WheelsParameters,
    dipole: Array,
    by_dipole: Array,
) -> tuple[Array, Array, Array]:
    """Cost of an interval without its effort, its slope (z,), and (6,) that of the sunlight."""
    form = rows.form
    sun = to_body(at.quaternion(x), at.parts(stage.sun))
    found = collected(p.panels, sun, p.smoothing)
    gradient, hessian = by_turn(found, sun)
    weight = -stage.shone / p.energy_scale
    cost = weight * found.area
    powers = dipoles = None
    if form.powers:
        price = 0.5 * stage.paid * p.power_scale / p.energy_scale
        cost = cost + price * jnp.sum(controls.powers)
        powers = jnp.full(form.powers, 1.0) * price
    h = stage.step if form.magnetorquers == "managing" else stage.paid
    price, loss = h * p.dipole_price / p.energy_scale, h * p.dipole_loss / p.energy_scale
    if form.dipoles:
        each = price * p.dipole_limit
        decided = jnp.stack(at.dipole(controls, p, form))
        cost = cost + jnp.sum(jnp.concatenate([each, each]) * controls.dipoles)
        cost = cost + jnp.sum(loss * decided**2)
        lost = 2.0 * loss * decided * p.dipole_limit
        dipoles = jnp.concatenate([each + lost, each - lost])
    slope = rows.block(turn=weight * jnp.stack(gradient), powers=powers, dipoles=dipoles)
    if form.magnetorquers == "managing":
        size = jnp.sqrt(dipole * dipole + p.rounding * p.rounding)
        cost = cost + jnp.sum(price * (size - p.rounding) + loss * dipole**2)
        share = price * dipole / size + 2.0 * loss * dipole
        slope = slope + share[0] * by_dipole[0] + share[1] * by_dipole[1]
        slope = slope + share[2] * by_dipole[2]
    return cost, slope, weight * jnp.stack(list(hessian.values()))
