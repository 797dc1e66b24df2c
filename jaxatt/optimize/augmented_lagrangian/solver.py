"""Augmented-Lagrangian method for a programme without dynamics.

The loop is flat: every pass evaluates the constraints and derivatives once, decides whether the
inner minimisation has ended (then multipliers, penalty and smoothing are updated on the spot) and
takes one inner step.  In a batch no start therefore waits for another's inner loop.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize import features
from jaxatt.optimize.augmented_lagrangian.gauss_newton import LocalModel
from jaxatt.optimize.augmented_lagrangian.inner import inner_minimiser
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
from jaxatt.optimize.augmented_lagrangian.penalty import equality_cost, inequality_cost, pushed
from jaxatt.optimize.program import Program
from jaxatt.optimize.solution import Solution
from jaxatt.optimize.solver import Solver
from jaxatt.optimize.status import RUNNING


class Multipliers(NamedTuple):
    """Multipliers of the equalities (m,), inequalities (p,) and stage inequalities (N, q)."""

    equality: Array
    inequality: Array
    stage: Array


class _Values(NamedTuple):
    equality: Array
    inequality: Array
    stage: Array


class _State(NamedTuple):
    x: Array
    inner_state: Any
    terms: Terms
    inner_steps: Array
    stationarity: Array
    history: History


def _largest(values: Array) -> Array:
    return jnp.max(jnp.abs(values), initial=0.0)


def _evaluate(program: Program, x: Array, args: Any) -> _Values:
    return _Values(
        program.equality(x, args), program.inequality(x, args), program.stage_inequality(x, args)
    )


def _violation(program: Program, x: Array, args: Any, values: _Values) -> Array:
    hard = jnp.isinf(jnp.broadcast_to(program.equality_weight(x, args), values.equality.shape))
    return jnp.maximum(
        _largest(jnp.where(hard, values.equality, 0.0)),
        jnp.maximum(
            _largest(jnp.minimum(values.inequality, 0.0)),
            _largest(jnp.minimum(values.stage, 0.0)),
        ),
    )


def _equality_penalty(program: Program, x: Array, args: Any, penalty: Array, rows: Array) -> Array:
    weight = jnp.broadcast_to(program.equality_weight(x, args), rows.shape)
    return jnp.where(jnp.isinf(weight), penalty, weight)


def _merit(program: Program, x: Array, args: Any, values: _Values, terms: Terms) -> Array:
    """Augmented Lagrangian (Powell, Hestenes, Rockafellar form) at evaluated constraints."""
    multipliers, penalty, stage_penalty, smoothing = terms
    weight = _equality_penalty(program, x, args, penalty, values.equality)
    return (
        program.objective(x, args, smoothing)
        + equality_cost(multipliers.equality, weight, values.equality)
        + inequality_cost(multipliers.inequality, penalty, values.inequality)
        + inequality_cost(multipliers.stage, stage_penalty, values.stage)
    )


def _jacobian(function: Callable[[Array], Array], x: Array) -> tuple[Array, Array]:
    """Values (m,) and derivatives (m, N, b), by forward or reverse mode, whichever is cheaper."""
    rows = jax.eval_shape(function, x).shape[0]
    if rows == 0:
        return jnp.zeros((0,), x.dtype), jnp.zeros((0, *x.shape), x.dtype)
    if rows <= x.size:
        values, pullback = jax.vjp(function, x)
        return values, jax.vmap(lambda row: pullback(row)[0])(jnp.eye(rows, dtype=x.dtype))
    values, push = jax.linearize(function, x)
    columns = jax.vmap(push)(jnp.eye(x.size, dtype=x.dtype).reshape(x.size, *x.shape))
    return values, columns.T.reshape(rows, *x.shape)


def _stage_jacobian(program: Program, x: Array, args: Any) -> tuple[Array, Array]:
    """Stage inequalities (N, q) and their derivatives (N, q, b); row k depends on x[k] only."""
    values, push = jax.linearize(lambda y: program.stage_inequality(y, args), x)
    size = x.shape[1]
    columns = [push(jnp.zeros_like(x).at[:, i].set(1.0)) for i in range(size)]
    return values, jnp.stack(columns, axis=-1)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class AugmentedLagrangian(Solver):
    """Augmented-Lagrangian method for a `Program`; a start is x, (N, b).

    inner : name of the inner minimiser, see `inner_minimiser`.
    """

    schedule: Schedule
    inner: str = field(default="gauss-newton", metadata={"static": True})

    name = "augmented Lagrangian"
    supports = frozenset(
        {
            features.WITHOUT_DYNAMICS,
            features.EQUALITY,
            features.SOFT_ROWS,
            features.INEQUALITY,
            features.STAGE_INEQUALITY,
            features.HELD_VARIABLES,
        }
    )
    needs = frozenset({features.WITHOUT_DYNAMICS})
    calls_lapack = True
    batch_axis = 0
    passes = 8

    def init(self, program: Program, start: Array, args: Any) -> _State:
        """State of a start, with multipliers of zero."""
        x, dtype = start * 1.0, start.dtype
        empty = jax.eval_shape(lambda x: _evaluate(program, x, args), x)
        return _State(
            x,
            inner_minimiser(self.inner).init(x),
            first_terms(
                self.schedule,
                Multipliers(*(jnp.zeros(leaf.shape, dtype) for leaf in empty)),
                dtype,
            ),
            jnp.asarray(0),
            jnp.asarray(jnp.inf, dtype),
            first_history(dtype),
        )

    def step(self, program: Program, state: _State, args: Any) -> _State:
        """Update the multipliers, if it is time for that, and take an inner step."""
        schedule, inner = self.schedule, inner_minimiser(self.inner)
        x = state.x
        equality, equality_rows = _jacobian(lambda y: program.equality(y, args), x)
        inequality, inequality_rows = _jacobian(lambda y: program.inequality(y, args), x)
        stage, stage_rows = _stage_jacobian(program, x, args)
        values = _Values(equality, inequality, stage)
        free = program.free(x, args)
        violation = _violation(program, x, args, values)

        def estimate(terms: Terms) -> tuple[Multipliers, Array]:
            """First-order multiplier estimate, and the gradient of the augmented Lagrangian."""
            weight = _equality_penalty(program, x, args, terms.penalty, equality)
            estimates = Multipliers(
                terms.multipliers.equality + weight * equality,
                pushed(terms.multipliers.inequality, terms.penalty, inequality),
                pushed(terms.multipliers.stage, terms.stage_penalty, stage),
            )
            gradient = (
                jax.grad(program.objective)(x, args, terms.smoothing)
                + jnp.einsum("m,mki->ki", estimates.equality, equality_rows)
                - jnp.einsum("m,mki->ki", estimates.inequality, inequality_rows)
                - jnp.einsum("kq,kqi->ki", estimates.stage, stage_rows)
            )
            return estimates, gradient * free

        terms = state.terms
        estimates, gradient = estimate(terms)
        largest = jnp.maximum(
            _largest(estimates.equality),
            jnp.maximum(_largest(estimates.inequality), _largest(estimates.stage)),
        )
        slackness = jnp.maximum(
            _largest(jnp.minimum(jnp.maximum(inequality, 0.0), estimates.inequality)),
            _largest(jnp.minimum(jnp.maximum(stage, 0.0), estimates.stage)),
        )
        seen = Seen(violation, _largest(gradient), slackness, largest)
        hard = jnp.isinf(jnp.broadcast_to(program.equality_weight(x, args), equality.shape))
        fresh = estimates._replace(equality=jnp.where(hard, estimates.equality, 0.0))
        over = state.inner_steps >= schedule.max_inner
        ended, terms, history = decide(schedule, terms, state.history, seen, fresh, over)

        # One step of the inner minimisation.
        estimates, gradient = estimate(terms)
        active = jnp.where(estimates.stage > 0, terms.stage_penalty, 0.0)
        weight = _equality_penalty(program, x, args, terms.penalty, equality)
        model = LocalModel(
            program.curvature(x, args, terms.smoothing)
            + jnp.einsum("kq,kqi,kqj->kij", active, stage_rows, stage_rows),
            jnp.concatenate([equality_rows, inequality_rows]),
            jnp.concatenate([weight, jnp.where(estimates.inequality > 0, terms.penalty, 0.0)]),
            free,
        )

        def value_fn(y: Array) -> Array:
            return _merit(program, y, args, _evaluate(program, y, args), terms)

        step, inner_state = inner.update(
            gradient,
            state.inner_state,
            x,
            model=model,
            value=_merit(program, x, args, values, terms),
            grad=gradient,
            value_fn=value_fn,
        )
        moved = _State(
            x + step * free,
            inner_state,
            terms,
            jnp.where(ended, 1, state.inner_steps + 1),
            seen.stationarity,
            history,
        )
        held = state._replace(
            stationarity=seen.stationarity,
            terms=state.terms._replace(multipliers=fresh),
            history=state.history._replace(status=history.status),
        )
        going = history.status == RUNNING
        return jax.tree.map(lambda new, old: jnp.where(going, new, old), moved, held)

    def done(self, state: _State) -> Array:
        """Whether the start has converged, given up or run out of passes."""
        return done(self.schedule, state.history)

    def result(self, program: Program, state: _State, args: Any) -> Solution:
        """Result, with the constraints evaluated at the returned point."""
        x, schedule = state.x, self.schedule
        violation = _violation(program, x, args, _evaluate(program, x, args))
        return Solution(
            x,
            program.objective(x, args, jnp.asarray(schedule.smoothing_end, x.dtype)),
            final_status(schedule, state.history.status, violation),
            violation,
            state.stationarity,
            state.terms.multipliers,
            state.history.iterations,
        )
