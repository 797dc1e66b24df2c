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
from jaxatt.problems.net_power.wheels.algebra import back, chart, conjugate, stacked
from jaxatt.problems.net_power.wheels.friction_loss import friction_loss, friction_loss_slope
from jaxatt.problems.net_power.wheels.interval import motion
from jaxatt.problems.net_power.wheels.interval_cost import interval_cost
from jaxatt.problems.net_power.wheels.kept import Kept
from jaxatt.problems.net_power.wheels.margins import ends_of, margins
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.turn import multiplied, times
from jaxatt.simulation.momentum_model import Components


def linearisation(
    rows: Rows, x: Array, u: Array, x_next: Array, stage: WheelStage, p: WheelsParameters
) -> Linearisation:
    """See `OptimalControlProgram.linearisation`."""
    form, h = rows.form, stage.step
    controls = at.split(u, form)
    start = at.course(x, u, p, form)
    size = rows.directions.size

    def moved(by: Array) -> tuple[Components, Components]:
        found = motion(rows.directions.moved(start, by), h, stage.along, p, form)
        return found.turn, (*found.rate, *found.end_rate, *found.push, *found.dipole)

    (turn, small), (turned, changed) = jax.vmap(
        lambda way: jax.jvp(moved, (jnp.zeros(size),), (way,)),
        in_axes=0,
        out_axes=((None, None), 0),
    )(jnp.eye(size))
    ahead = multiplied(at.quaternion(x), turn)
    missing = multiplied(conjugate(at.quaternion(x_next)), ahead)
    sigma = times(1.0 / jnp.maximum(1.0 + missing[0], 1e-6), missing[1:])
    to_gap, to_start = stacked(chart(sigma)), stacked(back(turn))
    turning = times(2.0, multiplied(conjugate(turn), turned)[1:])
    pushed = changed[6:9] if form.torqued else ()
    managed = changed[9:] if form.magnetorquers == "managing" else ()
    along = jnp.stack([*turning, *changed[:6], *pushed, *managed])
    # A product of matrices, so that XLA does not compute the motion again for every use.
    by_z = along @ rows.directions_by_z(p)
    dipoles = 9 + len(pushed)
    by_motion, by_push, by_dipole = by_z[:9], by_z[9:dipoles], by_z[dipoles:]
    driven = at.product(p.to_stored, controls.scaled)
    gap = [
        jnp.stack(times(4.0, sigma)),
        at.stored(x, form) + h * driven - at.stored(x_next, form),
    ]
    dynamics = [
        to_gap @ (by_motion[:3] + rows.block(turn=to_start)),
        rows.stored + h * rows.driven(p),
    ]
    if form.torqued:
        carried = slice(4 + form.stored, 7 + form.stored)
        gap.append(x[carried] + jnp.stack(small[6:9]) / p.momentum_scale - x_next[carried])
        dynamics.append(by_push / p.momentum_scale + rows.block(total=jnp.eye(3)))
    ends = ends_of(rows, x, controls, h, jnp.stack(small[:6]), by_motion[3:], p)
    path, path_slope, spins = margins(rows, x, controls, ends, p)
    dipole = jnp.stack(small[9:])
    cost, by_cost, sunlit = interval_cost(rows, x, controls, stage, p, dipole, by_dipole)
    if form.pays_friction:
        cost = cost + friction_loss(ends.turning.speeds, stage, p)
        by_cost = by_cost + friction_loss_slope(ends.turning, stage, p)
    if form.charge:
        # The load only empties the battery.
        spent = cost + h * p.load / p.energy_scale
        gap.append((x[-1] - spent - x_next[-1])[None])
        dynamics.append(rows.block(charge=jnp.ones((1, 1))) - by_cost[None])
    effort = 2.0 * stage.paid * p.effort / p.energy_scale * controls.scaled
    kept = Kept(
        turn=4.0 / jnp.maximum(1.0 + turn[0], 1e-6) * jnp.stack(turn[1:]),
        chart=to_gap,
        back=to_start,
        motion=by_motion,
        sunlit=sunlit,
        spins=spins,
        wheels=ends.turning,
        dipole=dipole,
        by_dipole=by_dipole,
    )
    return Linearisation(
        jnp.concatenate(gap),
        jnp.concatenate(dynamics),
        by_cost + rows.block(torques=effort),
        kept,
        path,
        path_slope,
    )
