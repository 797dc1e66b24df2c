"""One programme from one start, in the scaled units of the solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from jax import Array

from jaxatt.optimize.dense.arrays import certain, namespace
from jaxatt.optimize.dense.called import AnyFunctions
from jaxatt.optimize.dense.constraints import Constraints
from jaxatt.optimize.dense.first_order import FirstOrder
from jaxatt.optimize.dense.local import Local
from jaxatt.optimize.dense.merit import Merit
from jaxatt.optimize.dense.residuals import Residuals, residuals
from jaxatt.optimize.dense.scaling import Scaling
from jaxatt.optimize.dense.state import Limits


@dataclass(frozen=True)
class Task:
    """A programme with its scaling.

    constraints : with the bounds of the scaled x.  own_penalty : (q,), the penalty that makes
    squared rows those of the constraints' own units.  inner : "newton", "gauss-newton", "lbfgs" or
    "adam".
    """

    functions: AnyFunctions
    args: Any
    constraints: Constraints
    scaling: Scaling
    own_penalty: Array
    limits: Limits
    inner: str

    @property
    def first_order(self) -> FirstOrder | None:
        """The first-order minimiser, if one was asked for."""
        return FirstOrder(self.inner) if self.inner in FirstOrder.NAMES else None

    def merits(self, points: Array, merit: Merit) -> Array:
        """Merit (k,) at points (k, n), inf where anything is not finite."""
        scaling = self.scaling
        points = points * scaling.unit[None, :]
        return self.functions.merits(points, self.args, scaling.rows, merit)

    def merit(self, x: Array, merit: Merit) -> Array:
        """Merit () at one point (n,), for whose derivatives the host asks next."""
        at, finite = self.local(x)
        xp = namespace(x)
        return xp.where(finite, merit.value(at.objective, at.rows, merit.estimate(at.rows)), xp.inf)

    def local(self, x: Array) -> tuple[Local, Array]:
        """Objective and constraints with their first derivatives, and whether all is finite."""
        xp, scaling = namespace(x), self.scaling
        rows, derivatives = self.functions.derivatives(x * scaling.unit, self.args)
        rows, derivatives = rows * scaling.rows, derivatives * scaling.derivatives
        finite = xp.all(xp.isfinite(rows)) & xp.all(xp.isfinite(derivatives))
        return Local(rows[0], rows[1:], derivatives[0], derivatives[1:]), finite

    def hessian(self, x: Array, weight: Array, multipliers: Array) -> Array:
        """Second derivatives (n, n) of the Lagrangian, zero where they are not finite."""
        xp, scaling = namespace(x), self.scaling
        shares = xp.concatenate([weight[None], multipliers]) * scaling.rows
        hessian = self.functions.hessian(x * scaling.unit, self.args, shares) * scaling.hessian
        finite = xp.isfinite(hessian)
        return hessian if certain(xp.all(finite)) else xp.where(finite, hessian, 0.0)

    def residuals(self, at: Local, multipliers: Array, x: Array) -> Residuals:
        """First-order conditions at x with multipliers (q,), in the user's units."""
        return residuals(at, multipliers, x, self.constraints, self.scaling)
