"""Hessian of the Lagrangian of an interval.

It is a sum of products of two rows in z each, of which the transpose is added.  Turns a and b in
succession make a + b + (a x b) / 2.  The rotation vector r of an interval is the integral of the
rate and h^3 (omega x omega') / 12; r + e turns by e - (r x e) / 2 + (e x (r x e)) / 12 beyond r.
The rate is that of the momentum M in body axes: J_s omega = M - A s and M' = M x omega, which bends
the turn by the integral of m . (dM x d omega), m the adjoint of M, and by m . (the second order of
what a turned body sees of the momentum) at the beginning.

Exact where the next state is the one that the dynamics give, but for terms of h^4 and for what
external torques, and the dipole of a law, add to second order, which is small; a gap adds an error
of its own size.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.problems.net_power.wheels import coordinates as at
from jaxatt.problems.net_power.wheels.algebra import (
    combined,
    composed,
    dot,
    inverse,
    skew,
    stacked,
    symmetric_product,
    times_rows,
)
from jaxatt.problems.net_power.wheels.friction_loss import friction_loss_curvature
from jaxatt.problems.net_power.wheels.kept import Kept
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows
from jaxatt.problems.net_power.wheels.sunlight import PAIRS
from jaxatt.problems.net_power.wheels.turn import added, times
from jaxatt.simulation.momentum_model import Components, cross, matvec, to_body


def lagrangian_hessian(
    rows: Rows,
    x: Array,
    u: Array,
    x_next: Array,
    stage: WheelStage,
    p: WheelsParameters,
    costate: Array,
    kept: Any,
) -> Array:
    """See `OptimalControlProgram.lagrangian_hessian`."""
    form, h = rows.form, stage.step
    # What is paid: the charge's costate pays for the cost once more.
    paid = 1.0 - costate[form.error_size - 1] if form.charge else jnp.ones_like(h)
    force, turn = at.parts(at.product(kept.chart.T, costate[:3])), at.parts(kept.turn)
    by_end, by_rates = kept.motion[:3], kept.motion[3:]
    turning = at.parts(by_end)
    # Of the exponential: (e x (r x e)) / 12.
    along = dot(force, turn) / 6.0
    bend = [
        [along * (i == j) - (force[i] * turn[j] + turn[i] * force[j]) / 12.0 for j in range(3)]
        for i in range(3)
    ]
    half = times(0.5, force)
    by_turn = times_rows(kept.back.T, cross(turning, half))
    curved = {pair: paid * kept.sunlit[k] for k, pair in enumerate(PAIRS)}
    pressed = added(force, cross(turn, half))
    left, right = [by_end], []
    if form.momentum != "zero":
        of = _momentum(rows, x, h, p, pressed)
        seen = of.seen @ by_rates
        by_turn = added(by_turn, cross(at.parts(seen), of.total))
        if form.torqued:
            carried = rows.carried(at.quaternion(x), p)
            by_turn = added(by_turn, cross(of.early, at.parts(carried)))
            left.append(carried)
            right.append(seen)
        # M' = M x omega by the rate alone, with the turn over h for the rate.
        level, stiff = dot(of.far, of.total), 0.5 * inverse(h)
        for i in range(3):
            for j in range(3):
                mixed = of.far[i] * of.total[j] + of.total[i] * of.far[j]
                bend[i][j] = bend[i][j] + stiff * (mixed - 2.0 * level * (i == j))
        # A turned body sees the momentum phi x (phi x M) / 2 to second order.
        level = dot(of.early, of.total)
        for i, j in PAIRS:
            value = 0.5 * (of.early[i] * of.total[j] + of.total[i] * of.early[j])
            curved[i, j] = curved[i, j] + (value - level if i == j else value)
    wound = stacked(skew(times(h / 12.0, pressed)))
    turned = jnp.concatenate([0.5 * stacked(bend), wound, -wound], axis=1)
    # Products of matrices: what they take in is there once, and not computed again by XLA.
    right.insert(0, turned @ kept.motion)
    facing = [[0.5 * curved[min(i, j), max(i, j)] for j in range(3)] for i in range(3)]
    left.append(rows.turn)
    right.append(jnp.stack(by_turn) + rows.block(turn=stacked(facing)))
    for own, weighed in _of_dipoles(rows, stage, p, paid, kept):
        left.append(own)
        right.append(weighed)
    if form.pays_friction:
        own, weighed = friction_loss_curvature(kept.wheels, stage, p)
        left.append(own)
        right.append(paid * weighed)
    effort = 2.0 * stage.paid * p.effort / p.energy_scale
    of_torques = jnp.diag(rows.block(torques=jnp.ones(form.wheels) * effort))
    return symmetric_product(left, right) + of_torques


class _Momentum(NamedTuple):
    """What the total momentum adds.

    total : in body axes.  early : adjoint of it at the beginning, far : in the middle, times the
    part of the interval that counts from there.  seen : (3, 6), what makes of the rows of the rate
    at both ends what weighs the rows of a change of the momentum.
    """

    total: Components
    early: Components
    far: Components
    seen: Array


def _momentum(
    rows: Rows,
    x: Array,
    h: Array,
    p: WheelsParameters,
    pressed: Components,
) -> _Momentum:
    """Adjoint of the momentum to second order in h, and its integral by Simpson's rule.

    pressed : adjoint of the rotation vector.
    """
    total = to_body(at.quaternion(x), at.total_momentum(x, p, rows.form))
    omega = at.rate_of(x, total, p, rows.form)
    pull = matvec(p.inverse, pressed)
    tilt = added(cross(omega, pull), matvec(p.inverse, cross(pull, total)))
    early = added(times(h, pull), times(0.5 * h * h, tilt))
    middle = added(times(0.5 * h, pull), times(0.125 * h * h, tilt))
    # Of the rotation vector's h^2 omega x (the change of omega) / 12.
    twist = times(h * h / 12.0, matvec(p.inverse, cross(pressed, omega)))
    far = times(h, added(times(2.0 / 3.0, middle), twist))
    # By the middle the change of the momentum has turned with the body.
    late = combined((-1.0, skew(far)), (-0.5 * h, composed(skew(omega), skew(far))))
    first = combined((-h / 6.0, skew(early)), (0.5, late))
    seen = jnp.concatenate([stacked(first), 0.5 * stacked(late)], axis=1)
    return _Momentum(total, early, far, seen)


def _of_dipoles(
    rows: Rows, stage: WheelStage, p: WheelsParameters, paid: Array, kept: Kept
) -> list[tuple[Array, Array]]:
    """Rows whose products are half of what dipoles cost to second order."""
    form = rows.form
    if form.magnetorquers == "managing":
        size = jnp.sqrt(kept.dipole**2 + p.rounding**2)
        price = p.dipole_price * p.rounding**2 / (size * size * size)
        weight = 0.5 * paid * stage.step / p.energy_scale * (price + 2.0 * p.dipole_loss)
        return [(kept.by_dipole, weight[:, None] * kept.by_dipole)]
    if form.dipoles:
        lost = paid * stage.paid * p.dipole_loss * p.dipole_limit**2 / p.energy_scale
        ways = jnp.concatenate([jnp.eye(3), -jnp.eye(3)], axis=1)
        each = rows.block(dipoles=ways)
        return [(each, lost[:, None] * each)]
    return []
