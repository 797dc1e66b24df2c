"""Units of the variables and of the rows inside the solver."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import namespace

_LARGEST_SLOPE = 100.0
_SMALLEST_SCALE = 1e-8


class Scaling(NamedTuple):
    """What x is divided by and the rows are multiplied by, and what follows from that.

    unit : (n,), powers of two, so that nothing is rounded.  rows : (1 + q,), the objective first.
    derivatives : (1 + q, n) and hessian : (n, n), factors for those of the user's functions.
    multipliers : (q,), factors that take multipliers back to the user's units.
    slope : (n,), what a scaled gradient is divided by to be the user's.
    """

    unit: Array
    rows: Array
    derivatives: Array
    hessian: Array
    multipliers: Array
    slope: Array


def scaling_of(unit: Array, rows: Array) -> Scaling:
    """Scaling for units (n,) and factors of the rows (1 + q,)."""
    return Scaling(
        unit=unit,
        rows=rows,
        derivatives=rows[:, None] * unit[None, :],
        hessian=unit[:, None] * unit[None, :],
        multipliers=rows[1:] / rows[0],
        slope=rows[0] * unit,
    )


def scale_of(derivatives: Array) -> Array:
    """Factors that limit the gradient of every row to 100, as IPOPT does.

    derivatives : (1 + q, n) at the start.  Source: Waechter & Biegler (2006), section 3.8.
    """
    xp = namespace(derivatives)
    steepest = xp.max(abs(derivatives), axis=1)
    steepest = xp.where(xp.isfinite(steepest), steepest, 1.0)
    return xp.maximum(_SMALLEST_SCALE, xp.minimum(1.0, _LARGEST_SLOPE / steepest))
