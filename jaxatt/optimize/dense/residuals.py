"""Residuals of the first-order conditions, in the user's units."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.dense.functions import Local

_USUAL_MULTIPLIER = 100.0
_MOST_DIVISOR = 100.0


class Box(NamedTuple):
    """Bounds on the variables, (n,) each; -inf and inf where there is none."""

    lower: Array
    upper: Array

    def project(self, x: Array) -> Array:
        """The nearest point inside the bounds."""
        return jnp.clip(x, self.lower, self.upper)


class Residuals(NamedTuple):
    """Residuals of the first-order conditions; all () but the multipliers.

    violation : largest violation of a constraint.  stationarity : the larger of the scaled
    gradient of the Lagrangian and the scaled complementarity.  product : the latter's part of
    constraints, multiplier times value.  total : the largest of all.
    multipliers : (q,) of the stacked rows, those of inequalities not positive.
    lower, upper : (n,), not negative.
    """

    violation: Array
    stationarity: Array
    product: Array
    multipliers: Array
    lower: Array
    upper: Array

    @property
    def total(self) -> Array:
        """Largest residual; inf where anything is not finite."""
        total = jnp.maximum(self.violation, self.stationarity)
        return jnp.where(jnp.isfinite(total), total, jnp.inf)


def violated(rows: Array, equal: Array) -> Array:
    """Rows (q,) where they are violated, zero elsewhere; equal : (q,) bool."""
    return jnp.where(equal, rows, jnp.minimum(rows, 0.0))


def largest(values: Array) -> Array:
    """Largest magnitude; 0 for an empty array."""
    return jnp.max(jnp.abs(values), initial=0.0)


def _held(slope: Array, gap: Array) -> Array:
    """Multiplier of a bound, where attributing the gradient to the bound reduces the residual."""
    push = jnp.maximum(slope, 0.0)
    safe = jnp.where(jnp.isfinite(gap), gap, 0.0)
    blame = jnp.isfinite(gap) & (safe * jnp.maximum(1.0, push) < push)
    return jnp.where(blame, push, 0.0)


def residuals(
    at: Local,
    multipliers: Array,
    x: Array,
    box: Box,
    scale: Array,
    unit: Array,
    equal: Array,
) -> Residuals:
    """Residuals of the first-order conditions at x, (n,), in units of `unit`, (n,).

    multipliers : (q,) of the scaled rows.  scale : (1 + q,).  The gradient is divided by
    max(100, mean multiplier) / 100 and so are the products of complementarity, with the mean of
    all multipliers and of those of inequalities and bounds: Waechter & Biegler (2006), (5) and (6).
    Stricter than there: neither divisor exceeds 100 or the objective.
    Products with violated constraints count too, so that a constraint with a huge multiplier has
    to hold more tightly.
    """
    rows = at.rows / scale[1:]
    own = multipliers * scale[1:] / scale[0]
    own = jnp.where(equal, own, jnp.minimum(own, 0.0))
    slope = (at.slope + at.jacobian.T @ multipliers) / scale[0] / unit
    lower_gap, upper_gap = (x - box.lower) * unit, (box.upper - x) * unit
    lower, upper = _held(slope, lower_gap), _held(-slope, upper_gap)
    bounds = jnp.isfinite(box.lower).sum() + jnp.isfinite(box.upper).sum()
    sided = jnp.sum(jnp.abs(jnp.where(equal, 0.0, own))) + jnp.sum(lower) + jnp.sum(upper)
    every = sided + jnp.sum(jnp.abs(jnp.where(equal, own, 0.0)))

    def divisor(total: Array, count: Array, most: Array) -> Array:
        mean = total / jnp.maximum(1, count)
        return jnp.clip(mean / _USUAL_MULTIPLIER, 1.0, most)

    worth = jnp.maximum(1.0, jnp.abs(at.objective / scale[0]))
    most = jnp.minimum(_MOST_DIVISOR, worth)
    by_sided = divisor(sided, jnp.sum(~equal) + bounds, most)
    product = jnp.maximum(
        largest(jnp.where(equal, 0.0, own * rows)) / by_sided,
        largest(jnp.where(equal, own * rows, 0.0)) / divisor(every, own.shape[0] + bounds, most),
    )
    gaps = jnp.maximum(
        largest(jnp.where(lower > 0, lower * lower_gap, 0.0)),
        largest(jnp.where(upper > 0, upper * upper_gap, 0.0)),
    )
    apart = largest(jnp.where(equal, 0.0, jnp.minimum(jnp.maximum(rows, 0.0), -own)))
    steep = largest(slope - lower + upper)
    steep = steep / divisor(every, own.shape[0] + bounds, most)
    stationarity = jnp.max(jnp.stack([steep, product, gaps / by_sided, apart]))
    violation = largest(violated(rows, equal))
    return Residuals(violation, stationarity, product, own, lower, upper)
