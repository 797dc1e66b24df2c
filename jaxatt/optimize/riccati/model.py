"""Augmented Lagrangian of a staged programme, and the backward sweep that differentiates it.

The sweep carries two things from stage to stage: the costate, by differentiating the stage itself,
and the Riccati recursion on the quadratic model.  Seen from the controls alone the costate gives
the exact gradient, so the model is one of controls with that gradient and no linear term in the
states.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.augmented_lagrangian.outer import Terms
from jaxatt.optimize.augmented_lagrangian.penalty import equality_cost, inequality_cost
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.riccati.penalty import (
    Rows,
    differentiated,
    effective,
    final_rows,
    models_along,
    penalty_model,
    stage_rows,
)
from jaxatt.optimize.riccati.recursion import (
    StageModel,
    Trajectory,
    backward_step,
    derivatives_along,
)


class Multipliers(NamedTuple):
    """Multipliers of a staged programme.

    stage : Rows (N, q) and (N, p).  final : Rows (r,) and (t,).
    """

    stage: Rows
    final: Rows


class Sweep(NamedTuple):
    """Result of a backward sweep over a trajectory.

    merit : () the augmented Lagrangian.  gradient : () its largest derivative by a free control.
    laws : (N, b, n + 1), the step.  slope : () along it.  estimates : first-order multipliers.
    violation : () of all constraints.  slackness : () complementarity that is left.
    largest_multiplier : ().
    """

    merit: Array
    gradient: Array
    laws: Array
    slope: Array
    estimates: Multipliers
    violation: Array
    slackness: Array
    largest_multiplier: Array


def _largest(values: Array) -> Array:
    return jnp.max(jnp.abs(values), initial=0.0)


def _penalised(rows: Rows, multipliers: Rows, weight: Array, terms: Terms) -> Array:
    w = effective(weight, terms.penalty, rows.equality.shape)
    return equality_cost(multipliers.equality, w, rows.equality) + inequality_cost(
        multipliers.inequality, terms.stage_penalty, rows.inequality
    )


def no_multipliers(program: OptimalControlProgram, flown: Trajectory, args: Any) -> Multipliers:
    """Multipliers of zero."""

    def rows() -> tuple[Rows, Rows]:
        stage = jax.vmap(lambda x, u, s: stage_rows(program, x, u, s, args))(
            flown.x, flown.u, program.stages(args)
        )
        return stage, final_rows(program, flown.end, args)

    shapes = jax.eval_shape(rows)
    return Multipliers(*jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shapes))


def merit(
    program: OptimalControlProgram,
    flown: Trajectory,
    terms: Terms,
    args: Any,
    objective_only: bool = False,
) -> Array:
    """Augmented Lagrangian () of a trajectory, or its objective without constraints."""

    def add(total: Array, inputs: tuple[Array, Array, Any, Rows]) -> tuple[Array, None]:
        x, u, stage, multipliers = inputs
        cost = program.cost(x, u, stage, args, terms.smoothing)
        if not objective_only:
            rows = stage_rows(program, x, u, stage, args)
            weight = program.equality_weights(stage, args)
            cost = cost + _penalised(rows, multipliers, weight, terms)
        return total + cost, None

    last = jnp.zeros((), flown.u.dtype)
    if not objective_only:
        rows = final_rows(program, flown.end, args)
        last = _penalised(rows, terms.multipliers.final, program.final_weights(args), terms)
    inputs = (flown.x, flown.u, program.stages(args), terms.multipliers.stage)
    return lax.scan(add, last, inputs)[0]


class _Tally(NamedTuple):
    merit: Array
    gradient: Array
    slope: Array
    violation: Array
    slackness: Array
    largest_multiplier: Array


def _tallied(rows: Rows, estimates: Rows, weight: Array) -> tuple[Array, Array, Array, Rows]:
    """Violation, complementarity and largest multiplier of some rows, and multipliers to keep."""
    hard = jnp.isinf(jnp.broadcast_to(weight, rows.equality.shape))
    violation = jnp.maximum(
        _largest(jnp.where(hard, rows.equality, 0.0)), _largest(jnp.minimum(rows.inequality, 0.0))
    )
    slack = jnp.minimum(jnp.maximum(rows.inequality, 0.0), estimates.inequality)
    largest = jnp.maximum(_largest(estimates.equality), _largest(estimates.inequality))
    kept = estimates._replace(equality=jnp.where(hard, estimates.equality, 0.0))
    return violation, _largest(slack), largest, kept


def sweep(
    program: OptimalControlProgram, flown: Trajectory, terms: Terms, damping: Array, args: Any
) -> Sweep:
    """Sweep backwards over the stages: gradient, optimality tests and Riccati step."""
    n, size = program.error_size, flown.u.shape[1]
    dtype = flown.u.dtype
    zeros = jnp.zeros(n, dtype)

    def last(error: Array) -> Rows:
        return final_rows(program, program.retract(flown.end, error), args)

    final_weight = program.final_weights(args)
    rows, jacobian = differentiated(last, zeros)
    model = penalty_model(
        rows,
        jacobian,
        terms.multipliers.final,
        final_weight,
        terms.penalty,
        terms.stage_penalty,
    )
    violation, slack, largest, final_estimates = _tallied(rows, model.estimates, final_weight)
    cost = _penalised(rows, terms.multipliers.final, final_weight, terms)
    nothing = jnp.zeros((), dtype)
    first = (
        jnp.concatenate([model.hessian, zeros[:, None]], axis=1),
        model.gradient,
        _Tally(cost, nothing, nothing, violation, slack, largest),
    )

    def backwards(carry: tuple[Array, Array, _Tally], inputs: Any) -> tuple[Any, Any]:
        value, costate, tally = carry
        x, x_next, u, matrix, rows, model, multipliers, stage = inputs
        weight = program.equality_weights(stage, args)

        def through(z: Array) -> tuple[Array, Array]:
            x_moved, u_moved = program.retract(x, z[:n]), u + z[n:]
            cost = program.cost(x_moved, u_moved, stage, args, terms.smoothing)
            ahead = program.dynamics(x_moved, u_moved, stage, args)
            return cost + jnp.sum(costate * program.difference(ahead, x_next)), cost

        at = jnp.zeros(n + size, dtype)
        gradient, cost = jax.grad(through, has_aux=True)(at)
        gradient = gradient + model.gradient
        free = jnp.broadcast_to(program.free_controls(stage, args), u.shape)
        by_control = gradient[n:] * free
        curvature = program.cost_curvature(x, u, stage, args, terms.smoothing)
        value, law, slope, _ = backward_step(
            value,
            StageModel(matrix, curvature + model.hessian, jnp.concatenate([zeros, by_control])),
            free,
            jnp.zeros_like(u),
            damping,
        )
        violation, slack, largest, kept = _tallied(rows, model.estimates, weight)
        tally = _Tally(
            tally.merit + cost + _penalised(rows, multipliers, weight, terms),
            jnp.maximum(tally.gradient, _largest(by_control)),
            tally.slope + slope,
            jnp.maximum(tally.violation, violation),
            jnp.maximum(tally.slackness, slack),
            jnp.maximum(tally.largest_multiplier, largest),
        )
        return (value, gradient[:n], tally), (law, kept)

    inputs = (
        flown.x,
        jnp.concatenate([flown.x[1:], flown.end[None]]),
        flown.u,
        derivatives_along(program, flown, args),
        *models_along(
            program, flown, terms.multipliers.stage, terms.penalty, terms.stage_penalty, args
        ),
        terms.multipliers.stage,
        program.stages(args),
    )
    (_, _, tally), (laws, kept) = lax.scan(backwards, first, inputs, reverse=True)
    return Sweep(
        tally.merit,
        tally.gradient,
        laws,
        tally.slope,
        Multipliers(kept, final_estimates),
        tally.violation,
        tally.slackness,
        tally.largest_multiplier,
    )
