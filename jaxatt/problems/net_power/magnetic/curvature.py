"""Second derivatives of an interval in lanes: exact ones, and those that are never negative.

Source of the exact ones: Hager (2000), "Runge-Kutta methods in optimal control and the transformed
adjoint system".
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.attitude.components import Scalar, Vector
from jaxatt.optimize.lanes import computed_once, each_lane
from jaxatt.problems.net_power.magnetic.blocks import along_rows, on_rows, transposed
from jaxatt.problems.net_power.magnetic.motion import Here
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.rows import (
    MOVING,
    WIDTH,
    Point,
    ahead,
    chosen,
    points,
    times_row,
    unit_rows,
)
from jaxatt.problems.net_power.magnetic.slopes import Bends, bends, lost_power_bend, slopes
from jaxatt.simulation.momentum_model import Components


def exact_curvature(
    form: MagneticForm,
    at: Array,
    moved: Array,
    u: Array,
    costate: Array,
    seen: Here,
    final: Array,
    length: Array,
    p: MagneticParameters,
) -> Array:
    """Second derivatives (10, 10) of cost + costate (6,) . end, without their symmetry.

    All arrays have lanes behind their own axes.  at, moved : of the `Expansion`.  seen, final,
    length : as in `expanded`.
    """
    none = 0.0 * (at[0, 0] + u[0] + costate[0] + final)
    v = Vector(u[0] + none, u[1] + none, u[2] + none)
    unit = unit_rows(none)
    dipoles = unit[7:]
    rows = points(form.substeps)
    following = np.append(rows.before[1:], 0.0)
    scale = -p.scale * (1.0 if form.mean_power else final * p.unit)

    def bent_at(
        e: Vector,
        omega: Vector,
        v: Vector,
        weights: tuple[Vector, Vector, Scalar],
        seen: Here,
        p: MagneticParameters,
    ) -> tuple[tuple[Vector, Vector], Bends]:
        return bends(slopes(e, omega, v, seen, p), omega, weights, not form.mean_power, p)

    def back(carry: tuple[Any, ...], inputs: tuple[Any, ...]) -> tuple[tuple[Any, ...], Components]:
        at_end, gathered, later, lower = carry
        row, after, y, moved, seen = inputs
        pulls = zip(at_end, later, strict=True)
        weight = [length * final * (row.own * end + after * pull) for end, pull in pulls]
        e, omega = Vector(y[0], y[1], y[2]), Vector(y[3], y[4], y[5])
        weights = Vector(*weight[:3]), Vector(*weight[3:]), length * row.own * scale
        once = computed_once(each_lane(bent_at), jnp.asarray(row.instant >= 0))
        (by_turn, by_rate), bent = once(e, omega, v, weights, seen, p)
        pull = by_turn.parts + by_rate.parts
        turns, spins = [moved[k] for k in range(3)], [moved[k] for k in range(3, MOVING)]
        of_turn = zip(
            on_rows(bent.turn_turn, turns),
            on_rows(transposed(bent.rate_turn), spins),
            on_rows(transposed(bent.dipole_turn), dipoles),
            [times_row(part, unit[6]) for part in bent.turn_time.parts],
            strict=True,
        )
        of_rate = zip(
            on_rows(bent.rate_turn, turns),
            on_rows(bent.rate_rate, spins),
            [times_row(part, unit[6]) for part in bent.rate_time.parts],
            strict=True,
        )
        of_dipole = zip(
            on_rows(bent.dipole_turn, turns),
            [
                times_row(part, row)
                for part, row in zip(bent.dipole_dipole.parts, dipoles, strict=True)
            ],
            [times_row(part, unit[6]) for part in bent.dipole_time.parts],
            strict=True,
        )
        of_time = (
            along_rows(bent.turn_time, turns)
            + along_rows(bent.rate_time, spins)
            + along_rows(bent.dipole_time, dipoles)
            + times_row(bent.time_time, unit[6])
        )
        pulled = tuple(jnp.asarray(sum(parts)) for parts in [*of_turn, *of_rate])
        lower = ahead(lower, 1.0, (of_time, *(jnp.asarray(sum(parts)) for parts in of_dipole)))
        gathered = ahead(gathered, 1.0, pull)
        at_end = chosen(row.begins, ahead(at_end, 1.0, gathered), at_end)
        gathered = chosen(row.begins, still, gathered)
        return (at_end, gathered, pull, lower), pulled

    still = (none,) * MOVING
    at_end = tuple(costate[k] + none for k in range(MOVING))
    carry: tuple[Any, ...] = (at_end, still, still, (0.0 * unit[0],) * (WIDTH - MOVING))
    (_, _, _, lower), pulled = lax.scan(
        back, carry, (rows, following, at, moved, seen), reverse=True
    )
    upper = _products(moved, pulled)
    return jnp.concatenate([upper[:MOVING], upper[MOVING:] + jnp.stack(lower)])


def positive_curvature(
    form: MagneticForm,
    at: Array,
    moved: Array,
    seen: Here,
    final: Array,
    length: Array,
    p: MagneticParameters,
) -> Array:
    """Curvature (10, 10) of `MagneticInterval.gauss_newton`; arrays as in `exact_curvature`."""
    none = 0.0 * (at[0, 0] + final)
    unit = unit_rows(none)
    rows = points(form.substeps)
    scale = p.scale * (1.0 if form.mean_power else final * p.unit)

    def point(_: None, inputs: tuple[Point, Array, Array, Here]) -> tuple[None, Components]:
        row, y, moved, at = inputs
        once = computed_once(each_lane(lost_power_bend), jnp.asarray(row.instant >= 0))
        bent, weight = once(Vector(y[0], y[1], y[2]), at, p), length * row.own * scale
        turns = [moved[k] for k in range(3)]
        return None, tuple(times_row(weight, part) for part in on_rows(bent, turns))

    dipoles = jnp.zeros((WIDTH, WIDTH, 1))
    for k, row in enumerate(unit[7:]):
        paid = 2.0 * length * scale * p.dipole_power[k]
        dipoles = dipoles + times_row(paid, row)[:, None] * row[None]
    pulled = lax.scan(point, None, (rows, at, moved, seen))[1]
    return dipoles + _products(moved, pulled)


def _products(rows: Array, pulled: Components) -> Array:
    """Sum (10, 10) over the points of the products of rows with what weighs each.

    rows : (P, 6, 10), pulled : as many of (P, 10) as there are rows to be multiplied.  In a loop of
    its own, for which both are there: XLA would compute them again for every entry.
    """

    def point(total: Array, inputs: tuple[Array, Components]) -> tuple[Array, None]:
        own, weighing = inputs
        for k, weights in enumerate(weighing):
            total = total + own[k][:, None] * weights[None]
        return total, None

    blank = 0.0 * (rows[0, 0][:, None] + pulled[0][0][None])
    return lax.scan(point, blank, (rows, pulled))[0]
