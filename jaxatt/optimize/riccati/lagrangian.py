"""Augmented-Lagrangian method with Riccati steps for a programme in stages.

The loop is flat, like that of `augmented_lagrangian`, with which it shares the outer part: a pass
goes backwards over the stages once, which brings the exact gradient from the costate and a Riccati
step; then it either updates multipliers, penalty and smoothing, where the inner minimisation has
ended, or takes that step with a line search.  The gradient is the exact one even where the
derivatives in the quadratic model are not: the model shapes the step, the costate says when to
stop.

Source: Howell, Jackson and Manchester (2019), "ALTRO: a fast solver for constrained trajectory
optimization", with the multiplier formulas and statuses of this package.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize import features
from jaxatt.optimize.augmented_lagrangian.outer import (
    History,
    Schedule,
    Seen,
    Terms,
    decide,
    done,
    final_status,
    first_history,
    first_terms,
)
from jaxatt.optimize.optimal_control import OptimalControlProgram, fly
from jaxatt.optimize.riccati.model import Sweep, merit, no_multipliers, sweep
from jaxatt.optimize.riccati.recursion import Trajectory, fly_with_feedback
from jaxatt.optimize.solution import Solution
from jaxatt.optimize.solver import Solver
from jaxatt.optimize.status import RUNNING


class _State(NamedTuple):
    flown: Trajectory
    terms: Terms
    damping: Array
    steps: Array
    stuck: Array
    history: History


_LEAST_DAMPING = 1e-9
_MOST_DAMPING = 1e6
_SUFFICIENT = 1e-4
_SHORTER = 0.4
_SHORTEST = 1e-3
_ROUNDING = 1e-13


def _seen(found: Sweep) -> Seen:
    return Seen(
        found.violation, found.gradient, found.slackness, found.largest_multiplier, found.merit
    )


def _searched(
    program: OptimalControlProgram, state: _State, found: Sweep, args: Any
) -> tuple[Trajectory, Array, Array]:
    """Line search along a step: the trajectory, the step length and whether it was accepted."""

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


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class RiccatiLagrangian(Solver):
    """Augmented Lagrangian with Riccati steps for an `OptimalControlProgram`.

    A start is its controls, (N, b).

    schedule : `penalty` is that of the hard rows, `stage_penalty` that of the inequalities.
    """

    schedule: Schedule

    name = "augmented Lagrangian over stages"
    supports = frozenset(
        {
            features.DYNAMICS,
            features.PATH_EQUALITY,
            features.SOFT_PATH_ROWS,
            features.PATH_INEQUALITY,
            features.TERMINAL_EQUALITY,
            features.SOFT_TERMINAL_ROWS,
            features.TERMINAL_INEQUALITY,
            features.HELD_CONTROLS,
            features.MANIFOLD,
        }
    )
    needs = frozenset({features.DYNAMICS})
    passes = 8

    def init(self, program: OptimalControlProgram, start: Array, args: Any) -> _State:
        """State of the flight under these controls, with multipliers of zero."""
        u, dtype = start * 1.0, start.dtype
        flown = Trajectory(*fly(program, u, args), u)
        return _State(
            flown,
            first_terms(self.schedule, no_multipliers(program, flown, args), dtype),
            jnp.asarray(_LEAST_DAMPING, dtype),
            jnp.asarray(0),
            jnp.asarray(0),
            first_history(dtype),
        )

    def step(self, program: OptimalControlProgram, state: _State, args: Any) -> _State:
        """Update the multipliers, if it is time for that, or take an inner step."""
        schedule, terms = self.schedule, state.terms
        found = sweep(program, state.flown, terms, state.damping, args)
        over = (state.steps >= schedule.max_inner) | (state.stuck > 0)
        decision = decide(schedule, terms, state.history, _seen(found), found.estimates, over)
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
            terms=decision.terms,
            damping=jnp.asarray(_LEAST_DAMPING, damping.dtype),
            steps=jnp.asarray(0),
            stuck=jnp.asarray(0),
        )
        history = decision.history
        moved = jax.tree.map(lambda new, old: jnp.where(decision.ended, new, old), renewed, stepped)
        moved = moved._replace(history=history)
        held = state._replace(history=state.history._replace(status=history.status))
        going = history.status == RUNNING
        return jax.tree.map(lambda new, old: jnp.where(going, new, old), moved, held)

    def done(self, state: _State) -> Array:
        """Whether the start has converged, given up or run out of passes."""
        return done(self.schedule, state.history)

    def result(self, program: OptimalControlProgram, state: _State, args: Any) -> Solution:
        """Result, evaluated at the returned point."""
        found = sweep(program, state.flown, state.terms, state.damping, args)
        flown, schedule = state.flown, self.schedule
        smoothing = jnp.asarray(schedule.smoothing_end, flown.u.dtype)
        terms = state.terms._replace(smoothing=smoothing)
        return Solution(
            flown.u,
            merit(program, flown, terms, args, objective_only=True),
            final_status(schedule, state.history.status, found.violation),
            found.violation,
            _seen(found).stationarity,
            found.estimates,
            state.history.iterations,
            jnp.concatenate([flown.x, flown.end[None]]),
        )
