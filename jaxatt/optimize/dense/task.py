"""One programme from one start, in the scaled units of the solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from jax import Array

from jaxatt.optimize.dense.arrays import namespace
from jaxatt.optimize.dense.called import AnyFunctions
from jaxatt.optimize.dense.first_order import FirstOrder
from jaxatt.optimize.dense.functions import Local
from jaxatt.optimize.dense.residuals import Box, Residuals, residuals
from jaxatt.optimize.dense.state import Limits


@dataclass(frozen=True)
class Task:
    """A programme with its scaling.

    unit : (n,), what x is divided by.  scale : (1 + q,), what the rows are multiplied by.

    box : bounds of the scaled x.  equal : (q,) bool.  inner : "newton", "gauss-newton", "lbfgs" or
    "adam".
    """

    functions: AnyFunctions
    args: Any
    box: Box
    scale: Array
    unit: Array
    equal: Array
    limits: Limits
    inner: str

    @property
    def first_order(self) -> FirstOrder | None:
        """The first-order minimiser, if one was asked for."""
        return FirstOrder(self.inner) if self.inner in FirstOrder.NAMES else None

    def rows(self, points: Array) -> Array:
        """Objective and constraints, stacked, (k, 1 + q), at points (k, n)."""
        return self.functions.many(points * self.unit[None, :], self.args) * self.scale[None, :]

    @property
    def own_penalty(self) -> Array:
        """Penalty (q,) that makes squared rows those of the constraints' own units."""
        return 1.0 / self.scale[1:] ** 2

    def local(self, x: Array) -> Local:
        """Objective and constraints with their first derivatives."""
        rows, derivatives = self.functions.derivatives(x * self.unit, self.args)
        rows = rows * self.scale
        derivatives = derivatives * self.scale[:, None] * self.unit[None, :]
        return Local(rows[0], rows[1:], derivatives[0], derivatives[1:])

    def hessian(self, x: Array, weight: Array, multipliers: Array) -> Array:
        """Second derivatives (n, n) of the Lagrangian, zero where they are not finite."""
        xp = namespace(x)
        shares = xp.concatenate([weight[None], multipliers]) * self.scale
        hessian = self.functions.hessian(x * self.unit, self.args, shares)
        hessian = hessian * self.unit[:, None] * self.unit[None, :]
        return xp.where(xp.isfinite(hessian), hessian, 0.0)

    def residuals(self, at: Local, multipliers: Array, x: Array) -> Residuals:
        """First-order conditions at x with multipliers (q,), in the user's units."""
        return residuals(at, multipliers, x, self.box, self.scale, self.unit, self.equal)
