"""Residuals of the first-order conditions, in the user's units."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import certain, namespace
from jaxatt.optimize.dense.functions import Local

_USUAL_MULTIPLIER = 100.0
_MOST_DIVISOR = 100.0


class Box(NamedTuple):
    """Bounds on the variables, (n,) each; -inf and inf where there is none."""

    lower: Array
    upper: Array

    def project(self, x: Array) -> Array:
        """The nearest point inside the bounds, of x (n,) or of each of (k, n)."""
        xp = namespace(x)
        lower, upper = (side if x.ndim == 1 else side[None, :] for side in self)
        return xp.minimum(xp.maximum(x, lower), upper)


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
        xp = namespace(self.violation)
        total = xp.maximum(self.violation, self.stationarity)
        return xp.where(xp.isfinite(total), total, xp.inf)


def violated(rows: Array, equal: Array) -> Array:
    """Rows (q,) where they are violated, zero elsewhere; equal : (q,) bool."""
    xp = namespace(rows)
    return xp.where(equal, rows, xp.minimum(rows, 0.0))


def largest(values: Array) -> Array:
    """Largest magnitude; 0 for an empty array."""
    xp = namespace(values)
    return xp.max(abs(values), initial=0.0)


def _held(slope: Array, gap: Array) -> Array:
    """Multiplier of a bound, where attributing the gradient to the bound reduces the residual."""
    xp = namespace(slope)
    push = xp.maximum(slope, 0.0)
    safe = xp.where(xp.isfinite(gap), gap, 0.0)
    blame = xp.isfinite(gap) & (safe * xp.maximum(1.0, push) < push)
    return xp.where(blame, push, 0.0)


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
    xp = namespace(x)
    rows = at.rows / scale[1:]
    own = multipliers * scale[1:] / scale[0]
    own = xp.where(equal, own, xp.minimum(own, 0.0))
    slope = (at.slope + at.jacobian.T @ multipliers) / scale[0] / unit
    lower_gap, upper_gap = (x - box.lower) * unit, (box.upper - x) * unit
    bounds = xp.sum(xp.isfinite(box.lower)) + xp.sum(xp.isfinite(box.upper))
    if certain(bounds == 0):
        lower = upper = xp.zeros_like(slope)
    else:
        lower, upper = _held(slope, lower_gap), _held(-slope, upper_gap)
    sided = xp.sum(abs(xp.where(equal, 0.0, own))) + xp.sum(lower) + xp.sum(upper)
    every = sided + xp.sum(abs(xp.where(equal, own, 0.0)))

    def divisor(total: Array, count: Array, most: Array) -> Array:
        mean = total / xp.maximum(1, count)
        return xp.clip(mean / _USUAL_MULTIPLIER, 1.0, most)

    worth = xp.maximum(1.0, abs(at.objective / scale[0]))
    most = xp.minimum(_MOST_DIVISOR, worth)
    by_sided = divisor(sided, xp.sum(~equal) + bounds, most)
    product = xp.maximum(
        largest(xp.where(equal, 0.0, own * rows)) / by_sided,
        largest(xp.where(equal, own * rows, 0.0)) / divisor(every, own.shape[0] + bounds, most),
    )
    gaps = xp.maximum(
        largest(xp.where(lower > 0, lower * lower_gap, 0.0)),
        largest(xp.where(upper > 0, upper * upper_gap, 0.0)),
    )
    apart = largest(xp.where(equal, 0.0, xp.minimum(xp.maximum(rows, 0.0), -own)))
    steep = largest(slope - lower + upper)
    steep = steep / divisor(every, own.shape[0] + bounds, most)
    stationarity = xp.maximum(xp.maximum(steep, product), xp.maximum(gaps / by_sided, apart))
    violation = largest(violated(rows, equal))
    return Residuals(violation, stationarity, product, own, lower, upper)
