"""Residuals of the first-order conditions, in the user's units."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import namespace
from jaxatt.optimize.dense.constraints import Constraints
from jaxatt.optimize.dense.local import Local
from jaxatt.optimize.dense.scaling import Scaling

_USUAL_MULTIPLIER = 100.0
_MOST_DIVISOR = 100.0


class Residuals(NamedTuple):
    """Residuals of the first-order conditions; all () but the multipliers.

    violation : largest violation of a constraint.  stationarity : the larger of the scaled
    gradient of the Lagrangian and the scaled complementarity.  product : the latter's part of
    constraints, multiplier times value.  total : the largest of all; inf where anything is not
    finite.
    multipliers : (q,) of the stacked rows, those of inequalities not positive.
    bounds : (2n,) of the lower bounds, then of the upper ones, not negative.
    """

    violation: Array
    stationarity: Array
    product: Array
    total: Array
    multipliers: Array
    bounds: Array


def largest(values: Array) -> Array:
    """Largest magnitude; 0 for an empty array."""
    return _peak(abs(values))


def _peak(values: Array) -> Array:
    """Largest of (k,) or (k, n) that are not negative; 0 for an empty array."""
    return namespace(values).max(values, initial=0.0)


def residuals(
    at: Local, multipliers: Array, x: Array, constraints: Constraints, scaling: Scaling
) -> Residuals:
    """Residuals of the first-order conditions at x, (n,).

    multipliers : (q,) of the scaled rows.  The gradient is divided by
    max(100, mean multiplier) / 100 and so are the products of complementarity, with the mean of
    all multipliers and of those of inequalities and bounds: Waechter & Biegler (2006), (5) and (6).
    Stricter than there: neither divisor exceeds 100 or the objective.
    Products with violated constraints count too, so that a constraint with a huge multiplier has
    to hold more tightly.
    """
    xp, m, (q, n) = namespace(x), constraints.equalities, at.jacobian.shape
    rows = at.rows / scaling.rows[1:]
    own = xp.minimum(multipliers * scaling.multipliers, constraints.most)
    slope = (at.slope + multipliers.dot(at.jacobian)) / scaling.slope
    held, gaps = _held(slope, x, constraints, scaling)
    shares, bounds = abs(own), constraints.bounds
    sided = xp.sum(shares[m:]) + xp.sum(held)
    every = sided + xp.sum(shares[:m])
    most = xp.minimum(_MOST_DIVISOR, xp.maximum(1.0, abs(at.objective / scaling.rows[0])))

    def divisor(total: Array, count: Array) -> Array:
        mean = total / xp.maximum(1, count)
        return xp.clip(mean / _USUAL_MULTIPLIER, 1.0, most)

    by_sided, by_every = divisor(sided, q - m + bounds), divisor(every, q + bounds)
    products = abs(own * rows)
    product = xp.maximum(_peak(products[m:]) / by_sided, _peak(products[:m]) / by_every)
    apart = _peak(xp.minimum(xp.maximum(rows[m:], 0.0), -own[m:]))
    steep = largest(slope - held[:n] + held[n:]) / by_every
    stationarity = xp.maximum(xp.maximum(steep, product), xp.maximum(gaps / by_sided, apart))
    violation = largest(constraints.violated(rows))
    total = xp.maximum(violation, stationarity)
    total = xp.where(xp.isfinite(total), total, xp.inf)
    return Residuals(violation, stationarity, product, total, own, held)


def _held(
    slope: Array, x: Array, constraints: Constraints, scaling: Scaling
) -> tuple[Array, Array]:
    """Multipliers (2n,) of lower and upper bounds, and the largest product with a gap.

    A bound has one where attributing the gradient to it reduces the residual.
    """
    xp, box = namespace(x), constraints.box
    both = xp.concatenate([slope, -slope])
    if constraints.unbounded:
        return xp.zeros_like(both), xp.asarray(0.0)
    gap = xp.concatenate([(x - box.lower) * scaling.unit, (box.upper - x) * scaling.unit])
    push = xp.maximum(both, 0.0)
    blame = gap * xp.maximum(1.0, push) < push
    return xp.where(blame, push, 0.0), _peak(xp.where(blame, push * gap, 0.0))
