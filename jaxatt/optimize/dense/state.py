"""State of the dense solver between iterations."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.dense.residuals import Residuals

RUNNING = -1
"""Status of a start under way."""

FIRST_GOAL = 1e-2
_VIOLATION_COSTS = 10.0


class Phase(IntEnum):
    """Purpose of the current point.

    DESCENT : minimise the augmented Lagrangian.  NEWTON : a step on the first-order conditions is
    on trial.  RESTORATION : minimise the violation, whatever the objective.
    """

    DESCENT = 0
    NEWTON = 1
    RESTORATION = 2


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
        size = jnp.maximum(1.0, jnp.abs(self.objective))
        worth = self.objective + _VIOLATION_COSTS * size * jnp.cbrt(self.residuals.violation)
        return jnp.where(jnp.isnan(worth), jnp.inf, worth)

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


def choose(condition: Array, yes: Any, no: Any) -> Any:
    """Leafwise `jnp.where` with a scalar condition."""
    return jax.tree.map(lambda a, b: a if a is b else jnp.where(condition, a, b), yes, no)
