"""One interval by the classical Runge-Kutta formula, with first and second derivatives.

The coordinates within an interval are the turn e since its beginning, the rate omega_ib in radians
per unit of time (`MagneticParameters.unit`) and the logarithm of the final time.  The turn begins
at zero, where a small error of the attitude is a change of e, so the formula knows no manifold;
that holds up to the error of the steps, with which the derivatives are those of the interval.
The environment does not depend on the motion: it is evaluated once at the instants of the formula,
with its derivatives by the final time.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.optimize.lanes import in_lanes
from jaxatt.optimize.transcription.runge_kutta import Interval
from jaxatt.problems.net_power.magnetic.curvature import exact_curvature, positive_curvature
from jaxatt.problems.net_power.magnetic.expansion import Expansion, expanded
from jaxatt.problems.net_power.magnetic.motion import Here, Now, here, now, rates
from jaxatt.problems.net_power.magnetic.parameters import MagneticForm, MagneticParameters
from jaxatt.problems.net_power.magnetic.rows import MOVING, Point, points

Seen = TypeVar("Seen", Now, Here)


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
        index = points(steps).instant
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
        (_, total, _), _ = lax.scan(point, carry, (points(steps), seen))
        return total[:MOVING], total[MOVING]

    def expand(self, x: Array, u: Array, interval: Interval, p: MagneticParameters) -> Expansion:
        """Compute the first derivatives of an interval."""
        seen, final, length = self._along(here, x, interval, p, self.form.substeps)
        return in_lanes(functools.partial(expanded, self.form))(x[4:7], u, seen, final, length, p)

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
        curvature = in_lanes(functools.partial(exact_curvature, self.form))
        whole = curvature(found.at, found.moved, u, costate, seen, final, length, p)
        return jnp.asarray(0.5 * (whole + whole.T))

    def gauss_newton(
        self, found: Expansion, x: Array, u: Array, interval: Interval, p: MagneticParameters
    ) -> Array:
        """Curvature (10, 10) of the cost alone, as if the path were linear in all it depends on.

        Where the panels earn less than they could it is that of a cost which their best power
        bounds, so it is positive semidefinite, see `lost_power_bend`.
        """
        seen, final, length = self._along(here, x, interval, p, self.form.substeps)
        curvature = in_lanes(functools.partial(positive_curvature, self.form))
        whole = curvature(found.at, found.moved, seen, final, length, p)
        return jnp.asarray(0.5 * (whole + whole.T))
