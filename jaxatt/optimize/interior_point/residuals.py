"""Residuals of the first-order conditions in the interior-point method."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.interior_point.model import Bounded, Model, Values
from jaxatt.optimize.interior_point.state import Point

_LARGE_MULTIPLIER = 100.0


def largest(values: Array) -> Array:
    """Largest magnitude; 0 for an empty array."""
    return jnp.max(jnp.abs(values), initial=0.0)


class Residuals(NamedTuple):
    """Residuals of a point; all () but the last.

    gradient : of the Lagrangian.  gaps : of dynamics and all hard rows.  short : by which
    inequalities miss.  excess : of the inequalities over their slacks.  scale : of gradient and
    products.  products : of slacks and multipliers.
    """

    gradient: Array
    gaps: Array
    short: Array
    excess: Array
    scale: Array
    products: Bounded

    def stationarity(self, barrier: Array | float = 0.0) -> Array:
        """Scaled gradient of the Lagrangian, and deviation of the products from the barrier."""
        off = jnp.stack([largest(product - barrier) for product in self.products])
        return jnp.maximum(self.gradient, jnp.max(off)) / self.scale

    def error(self, barrier: Array) -> Array:
        """Largest residual of a barrier problem."""
        return jnp.maximum(self.stationarity(barrier), jnp.maximum(self.gaps, self.excess))

    @property
    def violation(self) -> Array:
        """Largest constraint violation of the programme itself, whatever the slacks."""
        return jnp.maximum(self.gaps, self.short)


def residuals(found: Model, point: Point, slack: Bounded, free_start: int) -> Residuals:
    """Compute the residuals of a point from its derivatives.

    free_start : coordinates of the first state that are decided.
    """
    dual, n = point.dual, found.costate.shape[0]
    by_control = found.gradient[:, n:] - dual.lower + dual.upper
    by_start, by_states = found.costate, jnp.zeros(0, by_control.dtype)
    if point.costates.shape[0]:
        # What the gradient of the Lagrangian changes by from the adjoint recursion's costates.
        off = point.costates - found.costates
        change = jnp.sum(found.dynamics * off[..., None], axis=1)
        by_control, by_start = by_control + change[:, n:], by_start + change[0, :n]
        by_states = jnp.concatenate([change[1:, :n], jnp.zeros_like(off[:1])]) - off
    by_start = by_start[n - free_start :]
    multipliers = jnp.stack(
        [largest(part) for part in (*dual, point.rows, point.equality, point.costates)]
    )
    return Residuals(
        gradient=jnp.maximum(
            jnp.maximum(largest(by_control), largest(by_start)), largest(by_states)
        ),
        gaps=jnp.maximum(
            jnp.maximum(largest(found.gap), largest(found.equality)), largest(found.rows)
        ),
        short=jnp.maximum(
            largest(jnp.minimum(found.path, 0.0)), largest(jnp.minimum(found.final, 0.0))
        ),
        excess=jnp.maximum(largest(found.path - slack.path), largest(found.final - slack.final)),
        scale=jnp.maximum(1.0, jnp.max(multipliers) / _LARGE_MULTIPLIER),
        products=jax.tree.map(lambda z, s: z * s, dual, slack),
    )


def unmet_at(found: Model, point: Point) -> Array:
    """As `unmet`, from a model."""
    rows = jnp.sum(jnp.abs(found.gap)) + jnp.sum(jnp.abs(found.rows))
    rows = rows + jnp.sum(jnp.abs(found.equality))
    excess = jnp.sum(jnp.abs(found.path - point.path))
    return rows + excess + jnp.sum(jnp.abs(found.final - point.final))


def unmet(found: Values, point: Point) -> Array:
    """Sum of the magnitudes of gaps, hard rows and violated inequalities, ()."""
    excess = jnp.sum(jnp.abs(found.path - point.path))
    return found.unmet + excess + jnp.sum(jnp.abs(found.final - point.final))
