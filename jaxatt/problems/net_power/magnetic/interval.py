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

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.optimize.transcription.runge_kutta import Interval
from jaxatt.problems.net_power.magnetic.blocks import along_rows, on_rows, transposed
from jaxatt.problems.net_power.magnetic.motion import Here, Now, here, now, rates
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.slopes import bends, lost_power_bend, slopes
from jaxatt.runtime.arrays import Flags, Floats

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
        v = Vector(u[0], u[1], u[2])
        dtype = x.dtype
        unit = jnp.eye(WIDTH, dtype=dtype)
        begin = jnp.concatenate([jnp.zeros(3, dtype), x[4:7], jnp.zeros(1, dtype)])
        spread = jnp.eye(MOVING + 1, WIDTH, dtype=dtype).at[MOVING].set(0.0)

        def point(
            carry: tuple[Array, ...], inputs: tuple[Point, Here]
        ) -> tuple[tuple[Array, ...], tuple[Array, Array]]:
            base, total, rate, by_base, by_total, by_rate = carry
            row, at = inputs
            base = jnp.where(row.begins, total, base)
            by_base = jnp.where(row.begins, by_total, by_base)
            y = base + length * row.before * rate
            moved = by_base + length * row.before * by_rate
            s = slopes(Vector(y[0], y[1], y[2]), Vector(y[3], y[4], y[5]), v, at, p)
            by_turn, by_spin = list(moved[:3]), list(moved[3:6])
            dipoles = [unit[7], unit[8], unit[9]]
            turning = on_rows(s.turning_by_turn, by_turn), on_rows(s.turning_by_rate, by_spin)
            spinning = (
                on_rows(s.spinning_by_turn, by_turn),
                on_rows(s.spinning_by_rate, by_spin),
                on_rows(s.spinning_by_dipole, dipoles),
            )
            later = (s.spinning + s.spinning_by_time).parts
            rows = [
                final * (sum(parts) + whole * unit[6])
                for *parts, whole in zip(*turning, s.turning.parts, strict=True)
            ] + [
                final * (sum(parts) + whole * unit[6])
                for *parts, whole in zip(*spinning, later, strict=True)
            ]
            weight = -p.scale * (1.0 if self.form.mean_power else final * p.unit)
            by_time = s.power_by_time + (0.0 if self.form.mean_power else s.power)
            shone = along_rows(s.power_by_turn, by_turn) + along_rows(s.power_by_dipole, dipoles)
            rows.append(weight * (shone + by_time * unit[6]))
            whole = [final * part for part in s.turning.parts + s.spinning.parts]
            rate, by_rate = jnp.stack([*whole, weight * s.power]), jnp.stack(rows)
            own = length * row.own
            ahead = (base, total + own * rate, rate, by_base, by_total + own * by_rate, by_rate)
            return ahead, (y[:MOVING], moved[:MOVING])

        carry: tuple[Array, ...] = (begin, begin, 0.0 * begin, spread, spread, 0.0 * spread)
        (_, total, _, _, by_total, _), kept = lax.scan(
            point, carry, (_points(self.form.substeps), seen)
        )
        return Expansion(total[:MOVING], by_total[:MOVING], total[MOVING], by_total[MOVING], *kept)

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
        v = Vector(u[0], u[1], u[2])
        unit = jnp.eye(WIDTH, dtype=x.dtype)
        rows = _points(self.form.substeps)
        following = np.append(rows.before[1:], 0.0)
        scale = -p.scale * (1.0 if self.form.mean_power else final * p.unit)

        def back(
            carry: tuple[Array, ...], inputs: tuple[Any, ...]
        ) -> tuple[tuple[Array, ...], None]:
            at_end, gathered, ahead, upper, lower = carry
            row, after, y, moved, at = inputs
            weight = length * final * (row.own * at_end + after * ahead)
            omega = Vector(y[3], y[4], y[5])
            s = slopes(Vector(y[0], y[1], y[2]), omega, v, at, p)
            (by_turn, by_rate), bent = bends(
                s,
                omega,
                (
                    Vector(weight[0], weight[1], weight[2]),
                    Vector(weight[3], weight[4], weight[5]),
                    length * row.own * scale,
                ),
                not self.form.mean_power,
                p,
            )
            here = jnp.stack([*by_turn.parts, *by_rate.parts])
            turns, spins = list(moved[:3]), list(moved[3:])
            dipoles = [unit[7], unit[8], unit[9]]
            of_turn = zip(
                on_rows(bent.turn_turn, turns),
                on_rows(transposed(bent.rate_turn), spins),
                on_rows(transposed(bent.dipole_turn), dipoles),
                [part * unit[6] for part in bent.turn_time.parts],
                strict=True,
            )
            of_rate = zip(
                on_rows(bent.rate_turn, turns),
                on_rows(bent.rate_rate, spins),
                [part * unit[6] for part in bent.rate_time.parts],
                strict=True,
            )
            of_dipole = zip(
                on_rows(bent.dipole_turn, turns),
                [part * row for part, row in zip(bent.dipole_dipole.parts, dipoles, strict=True)],
                [part * unit[6] for part in bent.dipole_time.parts],
                strict=True,
            )
            of_time = (
                along_rows(bent.turn_time, turns)
                + along_rows(bent.rate_time, spins)
                + along_rows(bent.dipole_time, dipoles)
                + bent.time_time * unit[6]
            )
            for pulled, row_of in zip([*of_turn, *of_rate], [*turns, *spins], strict=True):
                upper = upper + row_of[:, None] * jnp.asarray(sum(pulled))[None, :]
            lower = lower + jnp.stack([of_time, *(sum(parts) for parts in of_dipole)])
            gathered = gathered + here
            at_end = jnp.where(row.begins, at_end + gathered, at_end)
            gathered = jnp.where(row.begins, 0.0, gathered)
            return (at_end, gathered, here, upper, lower), None

        none = jnp.zeros(MOVING, x.dtype)
        blank = jnp.zeros((WIDTH, WIDTH), x.dtype)
        carry: tuple[Array, ...] = (costate, none, none, blank, blank[MOVING:])
        inputs: Any = (rows, following, found.at, found.moved, seen)
        (_, _, _, upper, lower), _ = lax.scan(back, carry, inputs, reverse=True)
        whole = jnp.concatenate([upper[:MOVING], upper[MOVING:] + lower])
        return 0.5 * (whole + whole.T)

    def gauss_newton(
        self, found: Expansion, x: Array, u: Array, interval: Interval, p: MagneticParameters
    ) -> Array:
        """Curvature (10, 10) of the cost alone, as if the path were linear in all it depends on.

        Where the panels earn less than they could it is that of a cost which their best power
        bounds, so it is positive semidefinite, see `lost_power_bend`.
        """
        seen, final, length = self._along(here, x, interval, p, self.form.substeps)
        rows = _points(self.form.substeps)
        scale = p.scale * (1.0 if self.form.mean_power else final * p.unit)
        unit = jnp.eye(WIDTH, dtype=x.dtype)

        def point(_: None, inputs: tuple[Point, Array, Array, Here]) -> tuple[None, Array]:
            row, y, moved, at = inputs
            turns = list(moved[:3])
            bent = lost_power_bend(Vector(y[0], y[1], y[2]), at, p)
            total = jnp.zeros((WIDTH, WIDTH), x.dtype)
            for row_of, pulled in zip(turns, on_rows(bent, turns), strict=True):
                total = total + row_of[:, None] * pulled[None, :]
            return None, length * row.own * scale * total

        _, parts = lax.scan(point, None, (rows, found.at, found.moved, seen))
        drawn = 2.0 * length * scale * p.dipole_power
        dipoles = sum(drawn[k] * unit[7 + k][:, None] * unit[7 + k][None, :] for k in range(3))
        whole = jnp.sum(parts, axis=0) + dipoles
        return 0.5 * (whole + whole.T)
