"""State of the dense solver between iterations."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from jax import Array

from jaxatt.optimize.dense.arrays import choose, namespace
from jaxatt.optimize.dense.residuals import Residuals

RUNNING = -1
"""Status of a start under way."""

FIRST_GOAL = 1e-2
_VIOLATION_COSTS = 10.0


class Phase:
    """Purpose of the current point.

    DESCENT : minimise the augmented Lagrangian.  NEWTON : a step on the first-order conditions is
    on trial.  RESTORATION : minimise the violation, whatever the objective.
    """

    DESCENT: Final = 0
    NEWTON: Final = 1
    RESTORATION: Final = 2


class Limits(NamedTuple):
    """Tolerance and iteration limits.

    tolerance : of violation and stationarity.  max_iterations : passes.  max_inner : passes until
    the multipliers are updated in any case.
    """

    tolerance: Array
    max_iterations: Array
    max_inner: Array


class Record(NamedTuple):
    """A recorded point: x (n,), scaled multipliers (q,), objective (), residuals."""

    x: Array
    multipliers: Array
    objective: Array
    residuals: Residuals

    @property
    def worth(self) -> Array:
        """Objective plus what a violation may gain where multipliers grow without limit."""
        xp = namespace(self.objective)
        size = xp.maximum(1.0, abs(self.objective))
        worth = self.objective + _VIOLATION_COSTS * size * xp.cbrt(self.residuals.violation)
        return xp.where(xp.isnan(worth), xp.inf, worth)

    def unless(self, replace: Array, other: Record) -> Record:
        """This record, or the other one where `replace` holds."""
        return choose(replace, other, self)


class Anchor(NamedTuple):
    """Point to return to after failed Newton steps: x (n,), multipliers (q,), residual ()."""

    x: Array
    multipliers: Array
    total: Array


class State(NamedTuple):
    """State of one start between iterations.

    x : (n,).  safe : (n,), last point with finite derivatives.  outer : (n,), where the inner
    minimisation began.  multipliers : (q,).  penalty, radius, goal : (), goal is the gradient at
    which the inner minimisation ends.  stuck : () bool, no trial lowered the merit.  curved : ()
    bool, negative curvature was seen.  method : state of a first-order minimiser.
    """

    x: Array
    safe: Array
    outer: Array
    multipliers: Array
    penalty: Array
    radius: Array
    goal: Array
    phase: Array
    anchor: Anchor
    inner: Array
    stuck: Array
    curved: Array
    violation: Array
    stalls: Array
    resets: Array
    restorations: Array
    escapes: Array
    retreats: Array
    settled: Array
    finishing: Array
    stationary: Record
    feasible: Record
    closest: Record
    status: Array
    iterations: Array
    method: Any
