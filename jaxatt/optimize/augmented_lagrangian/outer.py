"""Outer loop of the augmented Lagrangian: multipliers, penalties, smoothing and termination.

A pass says how far its point is from a minimum; this says whether the inner minimisation has ended
and the whole solve, and with which multipliers, penalties and smoothing it goes on.

Source: Nocedal & Wright, Numerical Optimization (2006), section 17.3 and algorithm 17.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.status import RUNNING, Status

LARGE_MULTIPLIER = 100.0
_LOOSE_STATIONARITY = 1e-2
_SHRINKS_WELL = 0.25
_SHRINKS = 0.9
_MOST_STALLS = 5


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Schedule:
    """Settings of a solve; all are traced, so changing one does not recompile.

    tolerance : on constraint violation.
    stationarity : on the scaled norm of the Lagrangian's gradient, and on complementary slackness.
    penalty, penalty_growth, penalty_limit : penalty of the constraints, its growth where the
        violation does not shrink, and its ceiling.
    stage_penalty : initial penalty of the stage inequalities.
    smoothing_start, smoothing_end, smoothing_factor : continuation of the objective's smoothing;
        it shrinks whenever an inner minimisation ends.
    max_inner : steps after which an inner minimisation ends in any case.
    max_iterations : total number of inner steps.
    update_multipliers : 0 for a pure penalty method, as a homotopy wants it; 1 otherwise.
    """

    tolerance: float = 1e-9
    stationarity: float = 1e-6
    penalty: float = 1e4
    penalty_growth: float = 10.0
    penalty_limit: float = 1e8
    stage_penalty: float = 1e2
    smoothing_start: float = 0.1
    smoothing_end: float = 1e-4
    smoothing_factor: float = 0.3
    max_inner: int = 6
    max_iterations: int = 60
    update_multipliers: float = 1.0


class Terms(NamedTuple):
    """Multipliers, penalties and smoothing that are fixed during an inner minimisation."""

    multipliers: Any
    penalty: Array
    stage_penalty: Array
    smoothing: Array


class History(NamedTuple):
    """Progress of a start.

    best_violation : () where an inner minimisation ended.  stalls : () of them without progress.
    status : () a `Status` or `RUNNING`.  iterations : () passes.
    """

    best_violation: Array
    stalls: Array
    status: Array
    iterations: Array


class Seen(NamedTuple):
    """Residuals that a pass finds at its point, all ().

    violation : of the constraints.  gradient : largest of the augmented Lagrangian.
    slackness : complementarity that is left.  largest_multiplier : of the first-order estimates.
    merit : the augmented Lagrangian, where the inner step needs it to be finite.
    """

    violation: Array
    gradient: Array
    slackness: Array
    largest_multiplier: Array
    merit: Array | float = 0.0

    @property
    def stationarity(self) -> Array:
        """Norm of the gradient, on the scale of large multipliers."""
        return self.gradient / jnp.maximum(1.0, self.largest_multiplier / LARGE_MULTIPLIER)


class Decision(NamedTuple):
    """Update after a pass.

    ended : () whether the inner minimisation has.  terms : for the next one if it has. history :
    after this pass.
    """

    ended: Array
    terms: Terms
    history: History


def first_terms(schedule: Schedule, multipliers: Any, dtype: Any) -> Terms:
    """Terms of the first inner minimisation."""
    return Terms(
        multipliers,
        jnp.asarray(schedule.penalty, dtype),
        jnp.asarray(schedule.stage_penalty, dtype),
        jnp.asarray(schedule.smoothing_start, dtype),
    )


def first_history(dtype: Any) -> History:
    """History of a start that has made no pass."""
    return History(
        jnp.asarray(jnp.inf, dtype), jnp.asarray(0), jnp.asarray(RUNNING), jnp.asarray(0)
    )


def decide(
    schedule: Schedule, terms: Terms, history: History, seen: Seen, estimates: Any, over: Array
) -> Decision:
    """Decide whether the inner minimisation has ended, and update the terms if it has.

    estimates : first-order multipliers.  over : () whether the inner minimisation has to end, be
    it at its minimum or not.
    """
    violation, stationarity = seen.violation, seen.stationarity
    finite = jnp.isfinite(violation) & jnp.isfinite(stationarity) & jnp.isfinite(seen.merit)
    final = terms.smoothing <= schedule.smoothing_end * (1.0 + 1e-9)
    loose = jnp.maximum(schedule.stationarity, _LOOSE_STATIONARITY)
    ended = (stationarity <= jnp.where(final, schedule.stationarity, loose)) | over
    feasible = violation <= schedule.tolerance
    optimal = jnp.maximum(stationarity, seen.slackness) <= schedule.stationarity
    update = ended & (schedule.update_multipliers > 0)
    stalled = update & ~feasible & (violation > _SHRINKS * history.best_violation)
    stalls = history.stalls + jnp.where(stalled, 1, 0)
    status = jnp.where(
        ~finite,
        Status.NOT_FINITE,
        jnp.where(
            final & feasible & optimal,
            Status.CONVERGED,
            jnp.where(stalls >= _MOST_STALLS, Status.INFEASIBLE, RUNNING),
        ),
    )
    shrunk = feasible | (violation <= _SHRINKS_WELL * history.best_violation)
    growth = jnp.where(update & ~shrunk, schedule.penalty_growth, 1.0)
    smoother = jnp.maximum(schedule.smoothing_end, terms.smoothing * schedule.smoothing_factor)
    renewed = Terms(
        jax.tree.map(lambda new, old: jnp.where(update, new, old), estimates, terms.multipliers),
        jnp.minimum(terms.penalty * growth, schedule.penalty_limit),
        jnp.minimum(terms.stage_penalty * growth, schedule.penalty_limit),
        jnp.where(ended, smoother, terms.smoothing),
    )
    least = jnp.minimum(history.best_violation, violation)
    best = jnp.where(ended, least, history.best_violation)
    return Decision(ended, renewed, History(best, stalls, status, history.iterations + 1))


def done(schedule: Schedule, history: History) -> Array:
    """Whether a start has converged, given up or run out of passes, ()."""
    return (history.status != RUNNING) | (history.iterations >= schedule.max_iterations)


def final_status(schedule: Schedule, status: Array, violation: Array) -> Array:
    """Status of a start that ended with this violation at the returned point, ()."""
    feasible = violation <= schedule.tolerance
    unfinished = jnp.where(feasible, Status.FEASIBLE, Status.ITERATION_LIMIT)
    return jnp.where(status == RUNNING, unfinished, status)
