"""Augmented Lagrangian for one start; `jax.vmap` makes it many.

The loop is flat: every pass evaluates the constraints and derivatives once, decides whether the
inner minimisation has ended (then multipliers, penalty and smoothing are updated on the spot) and
takes one inner step.  Under `vmap` no start therefore waits for another's inner loop, only for the
last start to end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import optax
from jax import Array, lax

from jaxatt.optimize.augmented_lagrangian.gauss_newton import LocalModel
from jaxatt.optimize.augmented_lagrangian.penalty import equality_cost, inequality_cost, pushed
from jaxatt.optimize.program import Program
from jaxatt.optimize.status import Status


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


class Multipliers(NamedTuple):
    """Multipliers of the equalities (m,), inequalities (p,) and stage inequalities (N, q)."""

    equality: Array
    inequality: Array
    stage: Array


class Solution(NamedTuple):
    """Where a start ended.

    x : (N, b).  objective : () at the final smoothing.  status : () a `Status`.
    violation : () largest constraint violation at x.  stationarity : () scaled norm of the
    Lagrangian's gradient where it was last evaluated (at x if the status is CONVERGED).
    multipliers : those whose stationarity was tested.  iterations : () inner steps taken.
    """

    x: Array
    objective: Array
    status: Array
    violation: Array
    stationarity: Array
    multipliers: Multipliers
    iterations: Array


class _Values(NamedTuple):
    equality: Array
    inequality: Array
    stage: Array


class _Terms(NamedTuple):
    """What makes the augmented Lagrangian of an inner minimisation."""

    multipliers: Multipliers
    penalty: Array
    stage_penalty: Array
    smoothing: Array


class _State(NamedTuple):
    x: Array
    inner_state: Any
    terms: _Terms
    inner_steps: Array
    best_violation: Array
    stalls: Array
    stationarity: Array
    status: Array
    iterations: Array


_RUNNING = -1
LARGE_MULTIPLIER = 100.0
_LOOSE_STATIONARITY = 1e-2
_SHRINKS_WELL = 0.25
_SHRINKS = 0.9
_MOST_STALLS = 5


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


def _merit(program: Program, x: Array, args: Any, values: _Values, terms: _Terms) -> Array:
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
    """Values (m,) and derivatives (m, N, b), by the cheaper of the two modes."""
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


def solve(
    program: Program,
    x0: Array,
    args: Any,
    schedule: Schedule,
    inner: optax.GradientTransformationExtraArgs,
) -> Solution:
    """Minimise a `Program` from one start.

    x0 : (N, b).  args : pytree handed to the program's functions.
    inner : optax transformation for the inner minimisation; one that takes the keyword `model`
    (see `gauss_newton`) gets the local curvature, others are called as optax calls them.

    Nothing raises inside; the outcome is in `Solution.status`.
    """
    x0 = x0 * 1.0
    dtype = x0.dtype
    empty = jax.eval_shape(lambda x: _evaluate(program, x, args), x0)
    zeros = Multipliers(*(jnp.zeros(leaf.shape, dtype) for leaf in empty))

    def as_array(value: float) -> Array:
        return jnp.asarray(value, dtype)

    def body(state: _State) -> _State:
        x = state.x
        equality, equality_rows = _jacobian(lambda y: program.equality(y, args), x)
        inequality, inequality_rows = _jacobian(lambda y: program.inequality(y, args), x)
        stage, stage_rows = _stage_jacobian(program, x, args)
        values = _Values(equality, inequality, stage)
        free = program.free(x, args)
        violation = _violation(program, x, args, values)

        def estimate(terms: _Terms) -> tuple[Multipliers, Array]:
            """First-order multiplier estimate and the gradient of the augmented Lagrangian."""
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

        # Has the inner minimisation ended, has the whole solve?
        terms = state.terms
        estimates, gradient = estimate(terms)
        largest = jnp.maximum(
            _largest(estimates.equality),
            jnp.maximum(_largest(estimates.inequality), _largest(estimates.stage)),
        )
        stationarity = _largest(gradient) / jnp.maximum(1.0, largest / LARGE_MULTIPLIER)
        final = terms.smoothing <= schedule.smoothing_end * (1.0 + 1e-9)
        loose = jnp.maximum(schedule.stationarity, _LOOSE_STATIONARITY)
        inner_minimum = stationarity <= jnp.where(final, schedule.stationarity, loose)
        ended = inner_minimum | (state.inner_steps >= schedule.max_inner)
        feasible = violation <= schedule.tolerance
        finite = jnp.isfinite(violation) & jnp.isfinite(stationarity)
        slackness = jnp.maximum(
            _largest(jnp.minimum(jnp.maximum(inequality, 0.0), estimates.inequality)),
            _largest(jnp.minimum(jnp.maximum(stage, 0.0), estimates.stage)),
        )
        optimal = jnp.maximum(stationarity, slackness) <= schedule.stationarity
        converged = final & feasible & optimal
        update = ended & (schedule.update_multipliers > 0)
        stalled = update & ~feasible & (violation > _SHRINKS * state.best_violation)
        stalls = state.stalls + jnp.where(stalled, 1, 0)
        status = jnp.where(
            ~finite,
            Status.NOT_FINITE,
            jnp.where(
                converged,
                Status.CONVERGED,
                jnp.where(stalls >= _MOST_STALLS, Status.INFEASIBLE, _RUNNING),
            ),
        )

        # If it has: new multipliers, penalty and smoothing, on the spot.
        hard = jnp.isinf(jnp.broadcast_to(program.equality_weight(x, args), equality.shape))
        fresh = estimates._replace(equality=jnp.where(hard, estimates.equality, 0.0))
        shrunk = feasible | (violation <= _SHRINKS_WELL * state.best_violation)
        growth = jnp.where(update & ~shrunk, schedule.penalty_growth, 1.0)
        terms = _Terms(
            jax.tree.map(lambda new, old: jnp.where(update, new, old), fresh, terms.multipliers),
            jnp.minimum(terms.penalty * growth, schedule.penalty_limit),
            jnp.minimum(terms.stage_penalty * growth, schedule.penalty_limit),
            jnp.where(
                ended,
                jnp.maximum(schedule.smoothing_end, terms.smoothing * schedule.smoothing_factor),
                terms.smoothing,
            ),
        )

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
            jnp.where(ended, jnp.minimum(state.best_violation, violation), state.best_violation),
            stalls,
            stationarity,
            status,
            state.iterations + 1,
        )
        held = state._replace(
            status=status,
            stationarity=stationarity,
            terms=state.terms._replace(multipliers=fresh),
        )
        return jax.tree.map(lambda new, old: jnp.where(status == _RUNNING, new, old), moved, held)

    def running(state: _State) -> Array:
        return (state.status == _RUNNING) & (state.iterations < schedule.max_iterations)

    start = _State(
        x0,
        inner.init(x0),
        _Terms(
            zeros,
            as_array(schedule.penalty),
            as_array(schedule.stage_penalty),
            as_array(schedule.smoothing_start),
        ),
        jnp.asarray(0),
        as_array(jnp.inf),
        jnp.asarray(0),
        as_array(jnp.inf),
        jnp.asarray(_RUNNING),
        jnp.asarray(0),
    )
    end = lax.while_loop(running, body, start)
    violation = _violation(program, end.x, args, _evaluate(program, end.x, args))
    unfinished = jnp.where(violation <= schedule.tolerance, Status.FEASIBLE, Status.ITERATION_LIMIT)
    status = jnp.where(end.status == _RUNNING, unfinished, end.status)
    return Solution(
        end.x,
        program.objective(end.x, args, as_array(schedule.smoothing_end)),
        status,
        violation,
        end.stationarity,
        end.terms.multipliers,
        end.iterations,
    )
