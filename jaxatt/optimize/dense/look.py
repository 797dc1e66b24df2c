"""First part of an iteration: differentiate, test optimality, update the records."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.active_set import fit
from jaxatt.optimize.dense.arrays import certain, choose, namespace
from jaxatt.optimize.dense.functions import Local
from jaxatt.optimize.dense.merit import Merit
from jaxatt.optimize.dense.state import Phase, Record, State
from jaxatt.optimize.dense.task import Task

_TARGET = 1e-10


class Look(NamedTuple):
    """Derivatives and tests at the current point.

    estimate : (q,), first-order multipliers.  here : the point as it would be remembered, with
    the multipliers that were tested.  total : (), largest residual, inf where anything is not
    finite.  met : () bool, constraints hold.  finishing : () bool, only the curvature is left to
    look at.  restoring, trying : () bool, the phase.
    """

    at: Local
    merit: Merit
    estimate: Array
    here: Record
    total: Array
    finite: Array
    met: Array
    finishing: Array
    restoring: Array
    trying: Array


def look(task: Task, s: State) -> tuple[State, Look]:
    """Test the first-order conditions at the current point and update the records."""
    x, tolerance = s.x, task.limits.tolerance
    xp = namespace(x)
    at = task.local(x)
    finite = at.finite
    restoring = s.phase == Phase.RESTORATION
    trying = s.phase == Phase.NEWTON
    weight = xp.where(restoring, 0.0, 1.0)
    merit = Merit(
        weight, s.multipliers, xp.where(restoring, task.own_penalty, s.penalty), task.equal
    )
    estimate = merit.estimate(at.rows)
    tested = xp.where(trying, s.multipliers, estimate)
    error = task.residuals(at, tested, x)
    if task.first_order is None and not certain(~trying):
        fitted = fit(at, tested, x, task.box, task.equal)
        error_fitted = task.residuals(at, fitted, x)
        fits = trying & (error_fitted.total < error.total)
        tested = xp.where(fits, fitted, tested)
        error = choose(fits, error_fitted, error)
        s = s._replace(multipliers=xp.where(fits, fitted, s.multipliers))
    total = xp.where(finite, error.total, xp.inf)
    here = Record(x, tested, at.objective / task.scale[0], error)
    met = finite & (error.violation <= tolerance)
    best = s.stationary.residuals.total
    falls = total < 0.5 * best
    settled = xp.where(best <= tolerance, xp.where(falls, 0, s.settled + 1), 0)
    s = s._replace(
        stationary=s.stationary.unless(total < best, here),
        feasible=s.feasible.unless(met & (here.worth < s.feasible.worth), here),
        closest=s.closest.unless(finite & (error.violation < s.closest.residuals.violation), here),
        settled=settled,
    )
    finishing = finite & (s.finishing | (total <= xp.minimum(tolerance, _TARGET)))
    return s, Look(at, merit, estimate, here, total, finite, met, finishing, restoring, trying)
