"""One interval by the classical Runge-Kutta formula, and its derivatives to second order.

The formula evaluates the rates at a few points, each a sum of the one before and the state at the
beginning.  So all that has to be differentiated are the rates: their Jacobians at those points give
the first derivatives by the chain rule, and what a costate makes of their Hessians there gives the
second ones, exactly.  The rates are traced once for the Jacobian and once for the Hessian, whatever
the number of points, and both derivatives share the Jacobians.

Source: Hager (2000), "Runge-Kutta methods in optimal control and the transformed adjoint system",
for the adjoint of the formula.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.optimize.riccati.recursion import product

Rate = Callable[[Array, Array, Array, Any], Array]


class Interval(NamedTuple):
    """time : () at its beginning and length : (), both in units of the whole horizon."""

    time: Array
    length: Array


class Points(NamedTuple):
    """Where the rates were evaluated, P points.

    at : (P, S + b), states and controls.  moved : (P, m, S + b), derivatives of the moving
    coordinates there by state and controls at the beginning.  slope : (P, r, S + b), of the rates.
    """

    at: Array
    moved: Array
    slope: Array


class Expansion(NamedTuple):
    """An interval to first order.

    end : (S,).  cost : ().  by_end : (m, S + b), derivatives of the moving coordinates at the end.
    by_cost : (S + b,).  points : what the second order needs.
    """

    end: Array
    cost: Array
    by_end: Array
    by_cost: Array
    points: Points


class Bending(NamedTuple):
    """hessian : (S + b, S + b) of cost + costate . end.  by_start : (m,), its gradient there."""

    hessian: Array
    by_start: Array


class _Formula(NamedTuple):
    """A row for every point: whether a step begins there, its share of the rate before it and of
    its own rate in the sum, in units of the interval, and when it is."""

    begins: Array
    before: Array
    own: Array
    when: Array


def _formula(steps: int) -> _Formula:
    h = 1.0 / steps
    begin = np.repeat(np.arange(steps) * h, 4)
    offset = np.tile([0.0, 0.5, 0.5, 1.0], steps) * h
    return _Formula(
        jnp.asarray(np.tile([True, False, False, False], steps)),
        jnp.asarray(offset),
        jnp.asarray(np.tile([1.0, 2.0, 2.0, 1.0], steps) * h / 6.0),
        jnp.asarray(begin + offset),
    )


@dataclass(frozen=True)
class RungeKutta:
    """Steps of the formula for a state y (S,) of which the first m coordinates move.

    rate : (y, u (b,), time (), args) -> (r,), the rates of those coordinates and, where r = m + 1,
    that of the cost, per horizon.  moving : m.  total : S.  controls : b.
    costs : whether there is a cost.  steps : of the formula in an interval.
    """

    rate: Rate
    moving: int
    total: int
    controls: int
    costs: bool
    steps: int

    def step(
        self, y: Array, u: Array, interval: Interval, args: Any, finer: int = 1
    ) -> tuple[Array, Array]:
        """State at the end, (S,), and cost, ().

        finer : how many times as many steps.
        """
        m = self.moving
        still = y[m:]
        nothing = jnp.zeros(m + self.costs, y.dtype)
        begin = jnp.concatenate([y[:m], nothing[m:]])

        def point(
            carry: tuple[Array, Array, Array], row: _Formula
        ) -> tuple[tuple[Array, Array, Array], None]:
            base, total, rate = carry
            base = jnp.where(row.begins, total, base)
            here = base[:m] + interval.length * row.before * rate[:m]
            when = interval.time + interval.length * row.when
            rate = self.rate(jnp.concatenate([here, still]), u, when, args)
            return (base, total + interval.length * row.own * rate, rate), None

        rows = _formula(self.steps * finer)
        (_, total, _), _ = lax.scan(point, (begin, begin, nothing), rows)
        end = jnp.concatenate([total[:m], still])
        return end, total[m] if self.costs else jnp.zeros((), y.dtype)

    def expand(self, y: Array, u: Array, interval: Interval, args: Any) -> Expansion:
        """The same to first order."""
        m, rates = self.moving, self.moving + self.costs
        width = self.total + self.controls
        dtype, still = y.dtype, y[m:]
        nothing, flat = jnp.zeros(rates, dtype), jnp.zeros((rates, width), dtype)
        begin = jnp.concatenate([y[:m], nothing[m:]])
        by_begin = jnp.eye(m, width, dtype=dtype)
        by_begin = jnp.concatenate([by_begin, flat[m:]])

        def point(carry: tuple[Array, ...], row: _Formula) -> tuple[tuple[Array, ...], Points]:
            base, total, rate, by_base, by_total, by_rate = carry
            base = jnp.where(row.begins, total, base)
            by_base = jnp.where(row.begins, by_total, by_base)
            share, own = interval.length * row.before, interval.length * row.own
            at = jnp.concatenate([base[:m] + share * rate[:m], still, u])
            moved = by_base[:m] + share * by_rate[:m]
            when = interval.time + interval.length * row.when

            def rated(z: Array) -> tuple[Array, Array]:
                found = self.rate(z[: self.total], z[self.total :], when, args)
                return found, found

            slope, rate = jax.jacfwd(rated, has_aux=True)(at)
            by_rate = product(slope[:, :m], moved)
            by_rate = by_rate + jnp.concatenate([flat[:, :m], slope[:, m:]], axis=1)
            ahead = (base, total + own * rate, rate, by_base, by_total + own * by_rate, by_rate)
            return ahead, Points(at, moved, slope)

        carry: tuple[Array, ...] = (begin, begin, nothing, by_begin, by_begin, flat)
        (_, total, _, _, by_total, _), points = lax.scan(point, carry, _formula(self.steps))
        end = jnp.concatenate([total[:m], still])
        if not self.costs:
            none = jnp.zeros(width, dtype)
            return Expansion(end, none[0], by_total, none, points)
        return Expansion(end, total[m], by_total[:m], by_total[m], points)

    def bend(self, points: Points, interval: Interval, costate: Array, args: Any) -> Bending:
        """Second derivatives of cost + costate . moving coordinates at the end, (m,)."""
        m, dtype = self.moving, costate.dtype
        rows = _formula(self.steps)
        whole = jnp.ones(int(self.costs), dtype)
        after = jnp.concatenate([rows.before[1:], jnp.zeros(1)])

        def back(
            carry: tuple[Array, Array, Array], inputs: tuple[Array, Array, Array, Array]
        ) -> tuple[tuple[Array, Array, Array], Array]:
            at_end, gathered, ahead = carry
            begins, own, following, slope = inputs
            weight = own * jnp.concatenate([at_end, whole])
            weight = weight + following * jnp.concatenate([ahead, 0.0 * whole])
            weight = interval.length * weight
            here = jnp.sum(slope[:, :m] * weight[:, None], axis=0)
            gathered = gathered + here
            at_end = jnp.where(begins, at_end + gathered, at_end)
            gathered = jnp.where(begins, 0.0, gathered)
            return (at_end, gathered, here), weight

        none = jnp.zeros(m, dtype)
        inputs = (rows.begins, rows.own, after, points.slope)
        (by_start, _, _), weights = lax.scan(back, (costate, none, none), inputs, reverse=True)

        def bent(at: Array, weight: Array, moved: Array, when: Array) -> Array:
            def weighed(z: Array) -> Array:
                time = interval.time + interval.length * when
                found = self.rate(z[: self.total], z[self.total :], time, args)
                return jnp.sum(weight * found)

            hessian = jax.jacfwd(jax.grad(weighed))(at)
            half = product(hessian[:, :m], moved)
            half = half + jnp.concatenate([jnp.zeros_like(hessian[:, :m]), hessian[:, m:]], axis=1)
            upper = product(moved.T, half[:m])
            return upper + jnp.concatenate([jnp.zeros_like(half[:m]), half[m:]])

        hessian = jnp.sum(jax.vmap(bent)(points.at, weights, points.moved, rows.when), axis=0)
        return Bending(0.5 * (hessian + hessian.T), by_start)
