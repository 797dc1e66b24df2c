"""Augmented Lagrangian of a staged programme for one start; `jax.vmap` makes it many.

The loop is flat, like that of `augmented_lagrangian`: a pass goes backwards over the stages once,
which brings the exact gradient from the costate and a Riccati step; then it either updates
multipliers, penalty and smoothing, where the inner minimisation has ended, or takes that step with
a line search.  The gradient is the exact one even where the derivatives in the quadratic model are
not: the model shapes the step, the costate says when to stop.

Source: Howell, Jackson and Manchester (2019), "ALTRO: a fast solver for constrained trajectory
optimization", with the multiplier formulas and statuses of this package.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.augmented_lagrangian.solver import Schedule
from jaxatt.optimize.optimal_control import OptimalControlProgram, fly
from jaxatt.optimize.riccati.model import Multipliers, Sweep, Terms, merit, no_multipliers, sweep
from jaxatt.optimize.riccati.recursion import Trajectory, fly_with_feedback
from jaxatt.optimize.status import Status


class StagedSolution(NamedTuple):
    """Where a start ended.

    x : (N, b), controls.  states : (N + 1, s).  objective : () at the final smoothing.
    status : () a `Status`.  violation : () largest constraint violation.  stationarity : () scaled
    norm of the Lagrangian's gradient, from the costate.  Both hold at the returned controls.
    multipliers : those whose stationarity was tested.  iterations : () passes.
    """

    x: Array
    states: Array
    objective: Array
    status: Array
    violation: Array
    stationarity: Array
    multipliers: Multipliers
    iterations: Array


class _State(NamedTuple):
    flown: Trajectory
    terms: Terms
    damping: Array
    steps: Array
    stuck: Array
    best_violation: Array
    stalls: Array
    status: Array
    iterations: Array


_RUNNING = -1
_LARGE_MULTIPLIER = 100.0
_LOOSE_STATIONARITY = 1e-2
_SHRINKS_WELL = 0.25
_SHRINKS = 0.9
_MOST_STALLS = 5
_LEAST_DAMPING = 1e-9
_MOST_DAMPING = 1e6
_SUFFICIENT = 1e-4
_SHORTER = 0.4
_SHORTEST = 1e-3
_ROUNDING = 1e-13


def _stationarity(found: Sweep) -> Array:
    return found.gradient / jnp.maximum(1.0, found.largest_multiplier / _LARGE_MULTIPLIER)


def _searched(
    program: OptimalControlProgram, state: _State, found: Sweep, args: Any
) -> tuple[Trajectory, Array, Array]:
    """The trajectory after a step, its length and whether it was accepted."""

    def flown(length: Array) -> tuple[Trajectory, Array]:
        trial, _ = fly_with_feedback(program, state.flown, found.laws, length, args)
        value = merit(program, trial, state.terms, args)
        allowed = found.merit + _SUFFICIENT * length * found.slope
        allowed = allowed + _ROUNDING * (1.0 + jnp.abs(found.merit))
        finite = jnp.all(jnp.isfinite(trial.end)) & jnp.all(jnp.isfinite(trial.u))
        return trial, (value <= allowed) & finite

    def going_on(carry: tuple[Array, Trajectory, Array]) -> Array:
        return ~carry[2] & (carry[0] > _SHORTEST)

    def shorter(
        carry: tuple[Array, Trajectory, Array],
    ) -> tuple[Array, Trajectory, Array]:
        length = carry[0] * _SHORTER
        return (length, *flown(length))

    whole = jnp.ones((), state.flown.u.dtype)
    length, trial, accepted = lax.while_loop(going_on, shorter, (whole, *flown(whole)))
    kept = jax.tree.map(lambda new, old: jnp.where(accepted, new, old), trial, state.flown)
    return kept, length, accepted


def solve_stages(
    program: OptimalControlProgram, u0: Array, args: Any, schedule: Schedule
) -> StagedSolution:
    """Minimise a `OptimalControlProgram` from one start.

    u0 : (N, b).  args : pytree handed to the programme's functions.
    schedule : `penalty` is that of the hard rows, `stage_penalty` that of the inequalities.

    Nothing raises inside; the outcome is in `StagedSolution.status`.
    """
    u0 = u0 * 1.0
    dtype = u0.dtype

    def as_array(value: float) -> Array:
        return jnp.asarray(value, dtype)

    def body(state: _State) -> _State:
        found = sweep(program, state.flown, state.terms, state.damping, args)
        terms = state.terms
        violation, stationarity = found.violation, _stationarity(found)
        final = terms.smoothing <= schedule.smoothing_end * (1.0 + 1e-9)
        loose = jnp.maximum(schedule.stationarity, _LOOSE_STATIONARITY)
        inner_minimum = stationarity <= jnp.where(final, schedule.stationarity, loose)
        ended = inner_minimum | (state.steps >= schedule.max_inner) | (state.stuck > 0)
        feasible = violation <= schedule.tolerance
        finite = jnp.isfinite(violation) & jnp.isfinite(stationarity) & jnp.isfinite(found.merit)
        optimal = jnp.maximum(stationarity, found.slackness) <= schedule.stationarity
        update = ended & (schedule.update_multipliers > 0)
        stalled = update & ~feasible & (violation > _SHRINKS * state.best_violation)
        stalls = state.stalls + jnp.where(stalled, 1, 0)
        status = jnp.where(
            ~finite,
            Status.NOT_FINITE,
            jnp.where(
                final & feasible & optimal,
                Status.CONVERGED,
                jnp.where(stalls >= _MOST_STALLS, Status.INFEASIBLE, _RUNNING),
            ),
        )

        shrunk = feasible | (violation <= _SHRINKS_WELL * state.best_violation)
        growth = jnp.where(update & ~shrunk, schedule.penalty_growth, 1.0)
        updated = Terms(
            jax.tree.map(
                lambda new, old: jnp.where(update, new, old), found.estimates, terms.multipliers
            ),
            jnp.minimum(terms.penalty * growth, schedule.penalty_limit),
            jnp.minimum(terms.stage_penalty * growth, schedule.penalty_limit),
            jnp.maximum(schedule.smoothing_end, terms.smoothing * schedule.smoothing_factor),
        )
        flown, length, accepted = _searched(program, state, found, args)
        whole = accepted & (length >= 1.0)
        damping = jnp.where(whole, 0.1 * state.damping, state.damping)
        damping = jnp.where(accepted, damping, jnp.maximum(1e-3, 30.0 * damping))
        stepped = state._replace(
            flown=flown,
            damping=jnp.clip(damping, _LEAST_DAMPING, _MOST_DAMPING),
            steps=state.steps + 1,
            stuck=jnp.where(accepted, 0, jnp.where(damping > _MOST_DAMPING, 1, 0)),
        )
        renewed = state._replace(
            terms=updated,
            damping=as_array(_LEAST_DAMPING),
            steps=jnp.asarray(0),
            stuck=jnp.asarray(0),
            best_violation=jnp.minimum(state.best_violation, violation),
            stalls=stalls,
        )
        moved = jax.tree.map(lambda new, old: jnp.where(ended, new, old), renewed, stepped)
        moved = moved._replace(iterations=state.iterations + 1)
        held = state._replace(status=status)
        return jax.tree.map(lambda new, old: jnp.where(status == _RUNNING, new, old), moved, held)

    def running(state: _State) -> Array:
        return (state.status == _RUNNING) & (state.iterations < schedule.max_iterations)

    x, last = fly(program, u0, args)
    start = _State(
        Trajectory(x, last, u0),
        Terms(
            no_multipliers(program, Trajectory(x, last, u0), args),
            as_array(schedule.penalty),
            as_array(schedule.stage_penalty),
            as_array(schedule.smoothing_start),
        ),
        as_array(_LEAST_DAMPING),
        jnp.asarray(0),
        jnp.asarray(0),
        as_array(jnp.inf),
        jnp.asarray(0),
        jnp.asarray(_RUNNING),
        jnp.asarray(0),
    )
    end = lax.while_loop(running, body, start)
    found = sweep(program, end.flown, end.terms, end.damping, args)
    unfinished = jnp.where(
        found.violation <= schedule.tolerance, Status.FEASIBLE, Status.ITERATION_LIMIT
    )
    terms = end.terms._replace(smoothing=as_array(schedule.smoothing_end))
    flown = end.flown
    return StagedSolution(
        flown.u,
        jnp.concatenate([flown.x, flown.end[None]]),
        merit(program, flown, terms, args, objective_only=True),
        jnp.where(end.status == _RUNNING, unfinished, end.status),
        found.violation,
        _stationarity(found),
        found.estimates,
        end.iterations,
    )
