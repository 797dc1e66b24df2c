"""First part of an iteration: differentiate, test optimality, update the records."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense.active_set import fit
from jaxatt.optimize.dense.arrays import certain, choose, namespace, no
from jaxatt.optimize.dense.local import Local
from jaxatt.optimize.dense.merit import Merit
from jaxatt.optimize.dense.state import Phase, Record, State
from jaxatt.optimize.dense.task import Task

_TARGET = 1e-10


class Look(NamedTuple):
    """Derivatives and tests at the current point.

    estimate : (q,), first-order multipliers.  gradient : (n,) of the merit.  here : the point as it
    would be remembered, with the multipliers that were tested.  total : (), largest residual, inf
    where anything is not finite.  met : () bool, constraints hold.  finishing : () bool, only the
    curvature is left to look at.  restoring, trying : () bool, the phase.
    """

    at: Local
    merit: Merit
    estimate: Array
    gradient: Array
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
    at, finite = task.local(x)
    restoring = s.phase == Phase.RESTORATION
    trying = s.phase == Phase.NEWTON
    weight = xp.where(restoring, 0.0, 1.0)
    penalty = choose(restoring, task.own_penalty, s.penalty)
    merit = Merit(weight, s.multipliers, penalty, task.constraints.most)
    estimate = merit.estimate(at.rows)
    gradient = merit.gradient(at, estimate)
    tested = choose(trying, s.multipliers, estimate)
    error = task.residuals(at, tested, x)
    multipliers = s.multipliers
    if task.first_order is None and not certain(no(trying)):
        fitted = fit(at, tested, x, task.constraints)
        error_fitted = task.residuals(at, fitted, x)
        fits = trying & (error_fitted.total < error.total)
        tested = choose(fits, fitted, tested)
        error = choose(fits, error_fitted, error)
        multipliers = choose(fits, fitted, multipliers)
    total = xp.where(finite, error.total, xp.inf)
    here = Record(x, tested, at.objective / task.scaling.rows[0], error)
    met = finite & (error.violation <= tolerance)
    best = s.stationary.residuals.total
    falls = total < 0.5 * best
    settled = xp.where(best <= tolerance, xp.where(falls, 0, s.settled + 1), 0)
    feasible = s.feasible
    if not certain(no(met)):
        feasible = feasible.unless(met & (here.worth < feasible.worth), here)
    s = s._replace(
        multipliers=multipliers,
        stationary=s.stationary.unless(total < best, here),
        feasible=feasible,
        closest=s.closest.unless(finite & (error.violation < s.closest.residuals.violation), here),
        settled=settled,
    )
    finishing = finite & (s.finishing | (total <= xp.minimum(tolerance, _TARGET)))
    return s, Look(
        at, merit, estimate, gradient, here, total, finite, met, finishing, restoring, trying
    )
