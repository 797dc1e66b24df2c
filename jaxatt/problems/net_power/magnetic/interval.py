"""One interval by the classical Runge-Kutta formula, with first and second derivatives.

The coordinates within an interval are the turn e since its beginning, the rate omega_ib in radians
per unit of time (`MagneticParameters.unit`) and the logarithm of the final time.  The turn begins
at zero, where a small error of the attitude is a change of e, so the formula knows no manifold;
that holds up to the error of the steps, with which the derivatives are those of the interval.
The environment does not depend on the motion: it is evaluated once at the instants of the formula,
with its derivatives by the final time.

Source of the second derivatives: Hager (2000), "Runge-Kutta methods in optimal control and the
transformed adjoint system".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Scalar, Vector
from jaxatt.optimize.lanes import computed_once, each_lane, in_lanes
from jaxatt.optimize.transcription.runge_kutta import Interval
from jaxatt.problems.net_power.magnetic.blocks import along_rows, on_rows, transposed
from jaxatt.problems.net_power.magnetic.motion import Here, Now, here, now, rates
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.slopes import Bends, bends, lost_power_bend, slopes
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.simulation.momentum_model import Components

Seen = TypeVar("Seen", Now, Here)

MOVING, WIDTH = 6, 10
"""Coordinates that move; directions: turn, rate, log of the time, dipole."""


class Point(NamedTuple):
    """Row of the formula: whether a step begins, shares of the rate before and of its own, its
    instant."""

    begins: Array | Flags
    before: Array | Floats
    own: Array | Floats
    instant: Array | npt.NDArray[np.int64]


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


def _points(steps: int) -> Point:
    h = 1.0 / steps
    return Point(
        np.tile([True, False, False, False], steps),
        np.tile([0.0, 0.5, 0.5, 1.0], steps) * h,
        np.tile([1.0, 2.0, 2.0, 1.0], steps) * h / 6.0,
        np.add.outer(2 * np.arange(steps), [0, 1, 1, 2]).ravel(),
    )


def _chosen(which: Array | Flags, new: Components, old: Components) -> Components:
    return tuple(jnp.where(which, a, b) for a, b in zip(new, old, strict=True))


def _ahead(base: Components, length: Array | float, rate: Components) -> Components:
    return tuple(b + length * r for b, r in zip(base, rate, strict=True))


def _times(factor: float, parts: Components) -> Components:
    return tuple(factor * part for part in parts)


def _by(factor: Scalar, row: Array | int) -> Array:
    """Product of an array () with lanes and a row (10,) with lanes."""
    return jnp.asarray(factor)[None] * row


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


def _unit_rows(like: Array) -> list[Array]:
    """Rows (10,) of the unit matrix, with the lanes of an array () with lanes."""
    rows = jnp.eye(WIDTH, dtype=like.dtype)[..., None] + like[None, None]
    return [rows[k] for k in range(WIDTH)]


class MagneticInterval:
    """Values and derivatives of an interval in one form of the programme."""

    def __init__(self, form: MagneticForm):
        self.form = form

    def _along(
        self,
        look: Callable[[Array, Quaternion, MagneticParameters, MagneticForm], Seen],
        x: Array,
        interval: Interval,
        p: MagneticParameters,
        steps: int,
    ) -> tuple[Seen, Array, Array]:
        """Environment at the points (P,), the final time in units of `p.unit`, and the interval's
        share of it.

        look : `now` or `here`.
        """
        final = jnp.exp(x[-1]) / p.unit
        instants = interval.time + interval.length * jnp.arange(2 * steps + 1) / (2 * steps)
        q0 = Quaternion.of(x[:4]).normalized()
        seen = jax.vmap(lambda when: look(when * final * p.unit, q0, p, self.form))(instants)
        index = _points(steps).instant
        return jax.tree.map(lambda leaf: leaf[index], seen), final, interval.length

    def step(
        self, x: Array, u: Array, interval: Interval, p: MagneticParameters, finer: int = 1
    ) -> tuple[Array, Array]:
        """Turn and rate at the end, (6,), and cost, ()."""
        steps = self.form.substeps * finer
        seen, final, length = self._along(now, x, interval, p, steps)
        v = Vector(u[0], u[1], u[2])
        begin = jnp.concatenate([jnp.zeros(3, x.dtype), x[4:7], jnp.zeros(1, x.dtype)])

        def point(
            carry: tuple[Array, Array, Array], inputs: tuple[Point, Now]
        ) -> tuple[tuple[Array, Array, Array], None]:
            base, total, rate = carry
            row, at = inputs
            base = jnp.where(row.begins, total, base)
            y = base + length * row.before * rate
            turning, spinning, power = rates(
                Vector(y[0], y[1], y[2]), Vector(y[3], y[4], y[5]), v, at, p
            )
            cost = -p.scale * power * (1.0 if self.form.mean_power else final * p.unit)
            rate = jnp.stack([*(final * part for part in turning.parts + spinning.parts), cost])
            return (base, total + length * row.own * rate, rate), None

        carry = (begin, begin, jnp.zeros_like(begin))
        (_, total, _), _ = lax.scan(point, carry, (_points(steps), seen))
        return total[:MOVING], total[MOVING]

    def expand(self, x: Array, u: Array, interval: Interval, p: MagneticParameters) -> Expansion:
        """Compute the first derivatives of an interval."""
        seen, final, length = self._along(here, x, interval, p, self.form.substeps)
        return in_lanes(self._expanded)(x[4:7], u, seen, final, length, p)

    def _expanded(
        self, spin: Array, u: Array, seen: Here, final: Array, length: Array, p: MagneticParameters
    ) -> Expansion:
        """As `expand`, all arrays with lanes behind their own axes.

        spin : (3,), rate at the beginning.  The rows of the derivatives are arrays of their own:
        to put them together at every point takes longer than to compute them.
        """
        none = 0.0 * (spin[0] + u[0] + final)
        v = Vector(u[0] + none, u[1] + none, u[2] + none)
        unit = _unit_rows(none)
        dipoles = unit[7:]
        begin: Components = (none, none, none, *(spin[k] + none for k in range(3)), none)
        spread: Components = (*unit[:MOVING], 0.0 * unit[0])

        def point(
            carry: tuple[Components, ...], inputs: tuple[Point, Here]
        ) -> tuple[tuple[Components, ...], tuple[Components, Components]]:
            base, total, rate, by_base, by_total, by_rate = carry
            row, at = inputs
            base = _chosen(row.begins, total, base)
            by_base = _chosen(row.begins, by_total, by_base)
            before, own = length * row.before, length * row.own
            y, moved = _ahead(base, before, rate), _ahead(by_base, before[None], by_rate)
            once = computed_once(each_lane(slopes), jnp.asarray(row.instant >= 0))
            s = once(Vector(*y[:3]), Vector(*y[3:6]), v, at, p)
            turns, spins = moved[:3], moved[3:6]
            turning = zip(
                on_rows(s.turning_by_turn, turns),
                on_rows(s.turning_by_rate, spins),
                [_by(part, unit[6]) for part in s.turning.parts],
                strict=True,
            )
            spinning = zip(
                on_rows(s.spinning_by_turn, turns),
                on_rows(s.spinning_by_rate, spins),
                on_rows(s.spinning_by_dipole, dipoles),
                [_by(part, unit[6]) for part in (s.spinning + s.spinning_by_time).parts],
                strict=True,
            )
            weight = -p.scale * (1.0 if self.form.mean_power else final * p.unit)
            by_time = s.power_by_time + (0.0 if self.form.mean_power else s.power)
            shone = along_rows(s.power_by_turn, turns) + along_rows(s.power_by_dipole, dipoles)
            whole = s.turning.parts + s.spinning.parts
            rate = (*(final * part for part in whole), weight * s.power)
            by_rate = tuple(_by(final, sum(parts)) for parts in [*turning, *spinning])
            by_rate = (*by_rate, _by(weight, shone + _by(by_time, unit[6])))
            total, by_total = _ahead(total, own, rate), _ahead(by_total, own[None], by_rate)
            return (base, total, rate, by_base, by_total, by_rate), (y[:MOVING], moved[:MOVING])

        still, level = _times(0.0, begin), _times(0.0, spread)
        carry: tuple[Components, ...] = (begin, begin, still, spread, spread, level)
        (_, total, _, _, by_total, _), (at, moved) = lax.scan(
            point, carry, (_points(self.form.substeps), seen)
        )
        ends = jnp.stack(total[:MOVING]), jnp.stack(by_total[:MOVING])
        return Expansion(*ends, total[-1], by_total[-1], jnp.stack(at, 1), jnp.stack(moved, 1))

    def second_order(
        self,
        found: Expansion,
        x: Array,
        u: Array,
        interval: Interval,
        costate: Array,
        p: MagneticParameters,
    ) -> Array:
        """Second derivatives (10, 10) of cost + costate (6,) . end."""
        seen, final, length = self._along(here, x, interval, p, self.form.substeps)
        whole = in_lanes(self._bent)(found.at, found.moved, u, costate, seen, final, length, p)
        return jnp.asarray(0.5 * (whole + whole.T))

    def _bent(
        self,
        at: Array,
        moved: Array,
        u: Array,
        costate: Array,
        seen: Here,
        final: Array,
        length: Array,
        p: MagneticParameters,
    ) -> Array:
        """Half of a matrix (10, 10) that `second_order` makes symmetric.

        All arrays have lanes behind their own axes.
        """
        none = 0.0 * (at[0, 0] + u[0] + costate[0] + final)
        v = Vector(u[0] + none, u[1] + none, u[2] + none)
        unit = _unit_rows(none)
        dipoles = unit[7:]
        rows = _points(self.form.substeps)
        following = np.append(rows.before[1:], 0.0)
        scale = -p.scale * (1.0 if self.form.mean_power else final * p.unit)

        def bent_at(
            e: Vector,
            omega: Vector,
            v: Vector,
            weights: tuple[Vector, Vector, Scalar],
            seen: Here,
            p: MagneticParameters,
        ) -> tuple[tuple[Vector, Vector], Bends]:
            return bends(slopes(e, omega, v, seen, p), omega, weights, not self.form.mean_power, p)

        def back(
            carry: tuple[Any, ...], inputs: tuple[Any, ...]
        ) -> tuple[tuple[Any, ...], Components]:
            at_end, gathered, ahead, lower = carry
            row, after, y, moved, seen = inputs
            pulls = zip(at_end, ahead, strict=True)
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
                [_by(part, unit[6]) for part in bent.turn_time.parts],
                strict=True,
            )
            of_rate = zip(
                on_rows(bent.rate_turn, turns),
                on_rows(bent.rate_rate, spins),
                [_by(part, unit[6]) for part in bent.rate_time.parts],
                strict=True,
            )
            of_dipole = zip(
                on_rows(bent.dipole_turn, turns),
                [
                    _by(part, row)
                    for part, row in zip(bent.dipole_dipole.parts, dipoles, strict=True)
                ],
                [_by(part, unit[6]) for part in bent.dipole_time.parts],
                strict=True,
            )
            of_time = (
                along_rows(bent.turn_time, turns)
                + along_rows(bent.rate_time, spins)
                + along_rows(bent.dipole_time, dipoles)
                + _by(bent.time_time, unit[6])
            )
            pulled = tuple(jnp.asarray(sum(parts)) for parts in [*of_turn, *of_rate])
            lower = _ahead(lower, 1.0, (of_time, *(jnp.asarray(sum(parts)) for parts in of_dipole)))
            gathered = _ahead(gathered, 1.0, pull)
            at_end = _chosen(row.begins, _ahead(at_end, 1.0, gathered), at_end)
            gathered = _chosen(row.begins, still, gathered)
            return (at_end, gathered, pull, lower), pulled

        still = (none,) * MOVING
        at_end = tuple(costate[k] + none for k in range(MOVING))
        carry: tuple[Any, ...] = (at_end, still, still, (0.0 * unit[0],) * (WIDTH - MOVING))
        (_, _, _, lower), pulled = lax.scan(
            back, carry, (rows, following, at, moved, seen), reverse=True
        )
        upper = _products(moved, pulled)
        return jnp.concatenate([upper[:MOVING], upper[MOVING:] + jnp.stack(lower)])

    def gauss_newton(
        self, found: Expansion, x: Array, u: Array, interval: Interval, p: MagneticParameters
    ) -> Array:
        """Curvature (10, 10) of the cost alone, as if the path were linear in all it depends on.

        Where the panels earn less than they could it is that of a cost which their best power
        bounds, so it is positive semidefinite, see `lost_power_bend`.
        """
        seen, final, length = self._along(here, x, interval, p, self.form.substeps)
        whole = in_lanes(self._positive)(found.at, found.moved, seen, final, length, p)
        return jnp.asarray(0.5 * (whole + whole.T))

    def _positive(
        self,
        at: Array,
        moved: Array,
        seen: Here,
        final: Array,
        length: Array,
        p: MagneticParameters,
    ) -> Array:
        """As `gauss_newton`, all arrays with lanes behind their own axes."""
        none = 0.0 * (at[0, 0] + final)
        unit = _unit_rows(none)
        rows = _points(self.form.substeps)
        scale = p.scale * (1.0 if self.form.mean_power else final * p.unit)

        def point(_: None, inputs: tuple[Point, Array, Array, Here]) -> tuple[None, Components]:
            row, y, moved, at = inputs
            once = computed_once(each_lane(lost_power_bend), jnp.asarray(row.instant >= 0))
            bent, weight = once(Vector(y[0], y[1], y[2]), at, p), length * row.own * scale
            turns = [moved[k] for k in range(3)]
            return None, tuple(_by(weight, part) for part in on_rows(bent, turns))

        dipoles = jnp.zeros((WIDTH, WIDTH, 1))
        for k, row in enumerate(unit[7:]):
            paid = 2.0 * length * scale * p.dipole_power[k]
            dipoles = dipoles + _by(paid, row)[:, None] * row[None]
        pulled = lax.scan(point, None, (rows, at, moved, seen))[1]
        return dipoles + _products(moved, pulled)
