"""Classical Runge-Kutta formula over one interval, with derivatives to second order.

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

Rate = Callable[[Array, Array, Array, Any], Array]


class Interval(NamedTuple):
    """Time and length of an interval.

    time : () at its beginning and length : (), both in units of the whole horizon.
    """

    time: Array
    length: Array


class Expansion(NamedTuple):
    """First-order expansion of an interval in z directions of its beginning, with P points.

    end : (S,).  cost : ().  by_end : (m, z), derivatives of the moving coordinates at the end.
    by_cost : (z,).  at : (P, S + b), states and controls where the rates were evaluated.
    moved : (P, m, z), derivatives of the moving coordinates there.
    """

    end: Array
    cost: Array
    by_end: Array
    by_cost: Array
    at: Array
    moved: Array


class SecondOrder(NamedTuple):
    """Second-order expansion of an interval, weighted by a costate.

    hessian : (z, z), in the directions of the beginning.  by_start : (m,), by the coordinates there
    that move.
    """

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
    """Runge-Kutta steps for a state y (S,), of which the first m coordinates move.

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

    def expand(
        self, y: Array, u: Array, interval: Interval, args: Any, spread: Array | None = None
    ) -> Expansion:
        """Compute the expansion of an interval to first order.

        spread : (m, z), derivatives of the moving coordinates at the beginning; the last S - m + b
        directions are those of the other coordinates and the controls.  By default it is 1.
        """
        m = self.moving
        dtype, still = y.dtype, y[m:]
        begin = jnp.concatenate([y[:m], jnp.zeros(self.costs, dtype)])
        if spread is None:
            spread = jnp.eye(m, self.total + self.controls, dtype=dtype)
        width = spread.shape[1]
        by_begin = jnp.concatenate([spread, jnp.zeros((self.costs, width), dtype)])
        nothing, flat = jnp.zeros_like(begin), jnp.zeros_like(by_begin)
        rest = self._rest(width, dtype)

        def point(
            carry: tuple[Array, ...], row: _Formula
        ) -> tuple[tuple[Array, ...], tuple[Array, Array]]:
            base, total, rate, by_base, by_total, by_rate = carry
            base = jnp.where(row.begins, total, base)
            by_base = jnp.where(row.begins, by_total, by_base)
            share, own = interval.length * row.before, interval.length * row.own
            at = jnp.concatenate([base[:m] + share * rate[:m], still, u])
            moved = by_base[:m] + share * by_rate[:m]
            when = interval.time + interval.length * row.when

            def along(direction: Array) -> tuple[Array, Array]:
                return jax.jvp(lambda z: self._rated(z, when, args), (at,), (direction,))

            columns = jnp.concatenate([moved, rest])
            rate, by_rate = jax.vmap(along, in_axes=1, out_axes=(None, 1))(columns)
            ahead = (base, total + own * rate, rate, by_base, by_total + own * by_rate, by_rate)
            return ahead, (at, moved)

        carry: tuple[Array, ...] = (begin, begin, nothing, by_begin, by_begin, flat)
        (_, total, _, _, by_total, _), points = lax.scan(point, carry, _formula(self.steps))
        end = jnp.concatenate([total[:m], still])
        if not self.costs:
            none = jnp.zeros(width, dtype)
            return Expansion(end, none[0], by_total, none, *points)
        return Expansion(end, total[m], by_total[:m], by_total[m], *points)

    def _rated(self, z: Array, when: Array, args: Any) -> Array:
        return self.rate(z[: self.total], z[self.total :], when, args)

    def _rest(self, width: int, dtype: Any) -> Array:
        """Derivatives of the coordinates that do not move, (S - m + b, z)."""
        rows = self.total + self.controls - self.moving
        return jnp.eye(rows, width, width - rows, dtype=dtype)

    def second_order(
        self, found: Expansion, interval: Interval, costate: Array, args: Any
    ) -> SecondOrder:
        """Second derivatives of cost + costate . moving coordinates at the end, (m,)."""
        m, dtype = self.moving, costate.dtype
        rows = _formula(self.steps)
        whole = jnp.ones(int(self.costs), dtype)
        after = jnp.concatenate([rows.before[1:], jnp.zeros(1)])

        def weighed(z: Array, weight: Array, when: Array) -> Array:
            rate = self._rated(z, interval.time + interval.length * when, args)
            return jnp.sum(weight * rate)

        def back(
            carry: tuple[Array, Array, Array], inputs: tuple[_Formula, Array, Array]
        ) -> tuple[tuple[Array, Array, Array], Array]:
            at_end, gathered, ahead = carry
            row, following, at = inputs
            weight = row.own * jnp.concatenate([at_end, whole])
            weight = weight + following * jnp.concatenate([ahead, 0.0 * whole])
            weight = interval.length * weight
            here = jax.grad(weighed)(at, weight, row.when)[:m]
            gathered = gathered + here
            at_end = jnp.where(row.begins, at_end + gathered, at_end)
            gathered = jnp.where(row.begins, 0.0, gathered)
            return (at_end, gathered, here), weight

        none = jnp.zeros(m, dtype)
        inputs = (rows, after, found.at)
        (by_start, _, _), weights = lax.scan(back, (costate, none, none), inputs, reverse=True)
        rest = self._rest(found.moved.shape[2], dtype)

        def pulled(direction: Array, only: Array) -> Array:
            """Hessians of the weighted rates at all points along one direction, (P, S + b)."""

            def at_point(at: Array, weight: Array, when: Array, moved: Array) -> Array:
                columns = jnp.concatenate([moved, only])
                return jax.jvp(jax.grad(lambda z: weighed(z, weight, when)), (at,), (columns,))[1]

            return jax.vmap(at_point)(found.at, weights, rows.when, direction)

        # A loop over the directions: what it leaves is there once, and not computed again by XLA
        # for every entry of the product that follows.
        directions = jnp.moveaxis(found.moved, 2, 0), rest.T
        bent = lax.scan(lambda _, row: (None, pulled(*row)), None, directions)[1]
        upper = jnp.sum(_times(found.moved, jnp.moveaxis(bent[:, :, :m], 0, 2)), axis=0)
        lower = jnp.sum(bent[:, :, m:], axis=1).T
        hessian = jnp.concatenate([upper[: -len(lower)], upper[-len(lower) :] + lower])
        return SecondOrder(0.5 * (hessian + hessian.T), by_start)


def _times(moved: Array, bent: Array) -> Array:
    """Sum of moved' bent over every point, (P, z, z), as rank-one products."""
    total = moved[:, 0, :, None] * bent[:, 0, None, :]
    for k in range(1, moved.shape[1]):
        total = total + moved[:, k, :, None] * bent[:, k, None, :]
    return total
