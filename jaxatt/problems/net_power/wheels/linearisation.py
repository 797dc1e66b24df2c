"""Intervals to first order, exactly.

What one does to the attitude, q+ = q (x) dq, is differentiated forwards by the turn of the body
where momentum or external torques make it matter, by the rate that the wheels have taken, by its
slope, and by the total momentum and the dipole where they vary.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import Linearisation
from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.algebra import back, chart, conjugate
from jaxatt.problems.net_power.wheels.friction_loss import friction_loss, friction_loss_slope
from jaxatt.problems.net_power.wheels.interval import motion
from jaxatt.problems.net_power.wheels.interval_cost import interval_cost
from jaxatt.problems.net_power.wheels.kept import Kept
from jaxatt.problems.net_power.wheels.margins import ends_of, margins
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.turn import multiplied, times


def linearisation(
    rows: Rows, x: Array, u: Array, x_next: Array, stage: WheelStage, p: WheelsParameters
) -> Linearisation:
    """See `OptimalControlProgram.linearisation`."""
    form, h, k = rows.form, stage.step, rows.form.stored
    controls = at.split(u, form)
    start = at.course(x, u, p, form)
    size, to_slope = rows.directions.size, rows.to_slope(p)

    def moved(by: Array) -> tuple[Array, Array]:
        found = motion(rows.directions.moved(start, by), h, stage.along, p, form)
        small = (*found.rate, *found.end_rate, *found.push, *found.dipole)
        return jnp.stack(found.turn), jnp.stack(small)

    (dq, small), (turned, changed) = jax.vmap(
        lambda way: jax.jvp(moved, (jnp.zeros(size),), (way,)),
        in_axes=0,
        out_axes=((None, None), 0),
    )(jnp.eye(size))

    def by_z(tangents: Array) -> list[Array]:
        return [rows.by_z(tangents[:, i], p, to_slope) for i in range(tangents.shape[1])]

    turn = (dq[0], dq[1], dq[2], dq[3])
    ahead = multiplied(at.quaternion(x), turn)
    missing = multiplied(conjugate(at.quaternion(x_next)), ahead)
    sigma = times(1.0 / jnp.maximum(1.0 + missing[0], 1e-6), missing[1:])
    to_gap, to_start = chart(sigma), back(turn)
    by_turn = multiplied(conjugate(turn), tuple(turned[:, i] for i in range(4)))[1:]
    turning = [rows.by_z(2.0 * by, p, to_slope) for by in by_turn]
    whole = [turning[i] + rows.row(turn=jnp.stack(to_start[i])) for i in range(3)]
    driven = at.product(p.to_stored, controls.scaled)
    gap = [
        jnp.stack(times(4.0, sigma)),
        at.stored(x, form) + h * driven - at.stored(x_next, form),
    ]
    own = jnp.eye(k)
    dynamics = [row[0] * whole[0] + row[1] * whole[1] + row[2] * whole[2] for row in to_gap]
    dynamics += [rows.row(stored=own[i], torques=h * p.to_stored[i]) for i in range(k)]
    if form.torqued:
        carried = slice(4 + k, 7 + k)
        gap.append(x[carried] + small[6:9] / p.momentum_scale - x_next[carried])
        pushed, kept_total = by_z(changed[:, 6:9] / p.momentum_scale), jnp.eye(3)
        dynamics += [pushed[i] + rows.row(total=kept_total[i]) for i in range(3)]
    by_dipole = jnp.zeros((0, rows.width))
    if form.magnetorquers == "managing":
        by_dipole = jnp.stack(by_z(changed[:, 9:12]))
    rates, by_rates = small[:6], jnp.stack(by_z(changed[:, :6]))
    ends = ends_of(rows, x, controls, h, rates, by_rates, p)
    path, path_slope, spins = margins(rows, x, controls, ends, p)
    cost, by_cost, sunlit = interval_cost(rows, x, controls, stage, p, small[9:12], by_dipole)
    if form.pays_friction:
        cost = cost + friction_loss(ends.turning.speeds, stage, p)
        by_cost = by_cost + friction_loss_slope(ends.turning, stage, p)
    if form.charge:
        # The load only empties the battery.
        spent = cost + h * p.load / p.energy_scale
        gap.append((x[-1] - spent - x_next[-1])[None])
        dynamics.append(rows.row(charge=jnp.ones(1)) - by_cost)
    effort = 2.0 * stage.paid * p.effort / p.energy_scale * controls.scaled
    kept = Kept(
        turn=4.0 / jnp.maximum(1.0 + dq[0], 1e-6) * dq[1:],
        chart=jnp.stack([jnp.stack(row) for row in to_gap]),
        back=jnp.stack([jnp.stack(row) for row in to_start]),
        turning=jnp.stack(turning),
        sunlit=sunlit,
        spins=spins,
        wheels=ends.turning,
        rates=by_rates,
        dipole=small[9:12],
        by_dipole=by_dipole,
    )
    return Linearisation(
        jnp.concatenate(gap),
        jnp.stack(dynamics),
        by_cost + rows.row(torques=effort),
        kept,
        path,
        path_slope,
    )
