"""First derivatives of an interval in lanes, forwards through the Runge-Kutta formula."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Vector
from jaxatt.optimize.lanes import computed_once, each_lane
from jaxatt.problems.net_power.magnetic.blocks import along_rows, on_rows
from jaxatt.problems.net_power.magnetic.motion import Here
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.rows import (
    MOVING,
    Point,
    ahead,
    chosen,
    points,
    scaled_by,
    times_row,
    unit_rows,
)
from jaxatt.problems.net_power.magnetic.slopes import slopes
from jaxatt.simulation.momentum_model import Components


class Expansion(NamedTuple):
    """First derivatives of an interval.

    end : (6,) and by_end : (6, 10).  cost : () and by_cost : (10,).
    at : (P, 6) and moved : (P, 6, 10), at the points of the formula.
    """

    end: Array
    by_end: Array
    cost: Array
    by_cost: Array
    at: Array
    moved: Array


def expanded(
    form: MagneticForm,
    spin: Array,
    u: Array,
    seen: Here,
    final: Array,
    length: Array,
    p: MagneticParameters,
) -> Expansion:
    """First derivatives of an interval; all arrays have lanes behind their own axes.

    spin : (3,), rate at the beginning.  seen : environment at the points, (P,).
    final : (), time in units of `p.unit`.  length : (), the interval's share of it.
    """
    none = 0.0 * (spin[0] + u[0] + final)
    v = Vector(u[0] + none, u[1] + none, u[2] + none)
    unit = unit_rows(none)
    dipoles = unit[7:]
    begin: Components = (none, none, none, *(spin[k] + none for k in range(3)), none)
    spread: Components = (*unit[:MOVING], 0.0 * unit[0])

    def point(
        carry: tuple[Components, ...], inputs: tuple[Point, Here]
    ) -> tuple[tuple[Components, ...], tuple[Components, Components]]:
        base, total, rate, by_base, by_total, by_rate = carry
        row, at = inputs
        base = chosen(row.begins, total, base)
        by_base = chosen(row.begins, by_total, by_base)
        before, own = length * row.before, length * row.own
        y, moved = ahead(base, before, rate), ahead(by_base, before[None], by_rate)
        once = computed_once(each_lane(slopes), jnp.asarray(row.instant >= 0))
        s = once(Vector(*y[:3]), Vector(*y[3:6]), v, at, p)
        turns, spins = moved[:3], moved[3:6]
        turning = zip(
            on_rows(s.turning_by_turn, turns),
            on_rows(s.turning_by_rate, spins),
            [times_row(part, unit[6]) for part in s.turning.parts],
            strict=True,
        )
        spinning = zip(
            on_rows(s.spinning_by_turn, turns),
            on_rows(s.spinning_by_rate, spins),
            on_rows(s.spinning_by_dipole, dipoles),
            [times_row(part, unit[6]) for part in (s.spinning + s.spinning_by_time).parts],
            strict=True,
        )
        weight = -p.scale * (1.0 if form.mean_power else final * p.unit)
        by_time = s.power_by_time + (0.0 if form.mean_power else s.power)
        shone = along_rows(s.power_by_turn, turns) + along_rows(s.power_by_dipole, dipoles)
        whole = s.turning.parts + s.spinning.parts
        rate = (*(final * part for part in whole), weight * s.power)
        by_rate = tuple(times_row(final, sum(parts)) for parts in [*turning, *spinning])
        by_rate = (*by_rate, times_row(weight, shone + times_row(by_time, unit[6])))
        total, by_total = ahead(total, own, rate), ahead(by_total, own[None], by_rate)
        return (base, total, rate, by_base, by_total, by_rate), (y[:MOVING], moved[:MOVING])

    still, level = scaled_by(0.0, begin), scaled_by(0.0, spread)
    carry: tuple[Components, ...] = (begin, begin, still, spread, spread, level)
    (_, total, _, _, by_total, _), (at, moved) = lax.scan(
        point, carry, (points(form.substeps), seen)
    )
    ends = jnp.stack(total[:MOVING]), jnp.stack(by_total[:MOVING])
    return Expansion(*ends, total[-1], by_total[-1], jnp.stack(at, 1), jnp.stack(moved, 1))
