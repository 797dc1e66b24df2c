"""Riccati recursion for the KKT matrix of a staged programme and any right-hand side.

It is the recursion of the interior point's Newton step with limits that either hold or do not.
Hard rows and active limits C get the small diagonal  - 1 / weight  that makes the system one of
weighted squares,  multiplier = weight (C step - right).  A few corrections with the exact matrix
remove what that is off by.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.interior_point.model import Bounded, Model
from jaxatt.optimize.interior_point.step import times, weighted
from jaxatt.optimize.riccati.recursion import StageModel, backward_step, eliminated

_CORRECTIONS = 1
_WEIGHT = 1e7
"""Of rows and active limits, in units of the largest curvature where that exceeds one."""


class StageResiduals(NamedTuple):
    """A right-hand side, or a step; fields as in `StagedPoint`, of error coordinates."""

    begin: Array
    x: Array
    u: Array
    costates: Array
    equality: Array
    rows: Array
    limits: Bounded


def staged_step(
    model: Model, active: Bounded, right: StageResiduals, free_start: int
) -> StageResiduals:
    """Solve the KKT system of a model.

    active : limits that hold.  free_start : coordinates of the first state that are decided.
    """

    def correct(_: int, step: StageResiduals) -> StageResiduals:
        left = jax.tree.map(jnp.subtract, right, product(model, active, step, free_start))
        return jax.tree.map(jnp.add, step, _weighted_step(model, active, left, free_start))

    nothing = jax.tree.map(jnp.zeros_like, right)
    return lax.fori_loop(0, 1 + _CORRECTIONS, correct, nothing)


def product(model: Model, active: Bounded, step: StageResiduals, free_start: int) -> StageResiduals:
    """KKT matrix times a step."""
    n = model.dynamics.shape[1]
    first = jnp.zeros(n, step.u.dtype).at[n - free_start :].set(step.begin)
    moved = jnp.concatenate([jnp.concatenate([first[None], step.x[:-1]]), step.u], axis=1)
    end, held = (
        step.x[-1],
        Bounded(*(jnp.where(a, z, 0.0) for a, z in zip(active, step.limits, strict=True))),
    )

    def back(slope: Array, by: Array) -> Array:
        return times(jnp.swapaxes(slope, -1, -2), by)

    z = times(model.hessian, moved) + back(model.dynamics, step.costates)
    z = z + back(model.equality_slope, step.equality) - back(model.path_slope, held.path)
    at_end = times(model.final_hessian, end) + back(model.rows_slope, step.rows)
    at_end = at_end - back(model.final_slope, held.final)
    by_states = jnp.concatenate([z[1:, :n], at_end[None]]) - step.costates
    margins = Bounded(
        times(model.path_slope, moved), times(model.final_slope, end), step.u, -step.u
    )
    return StageResiduals(
        z[0, n - free_start : n],
        by_states,
        z[:, n:] - held.lower + held.upper,
        times(model.dynamics, moved) - step.x,
        times(model.equality_slope, moved),
        times(model.rows_slope, end),
        Bounded(
            *(
                jnp.where(a, -change, -z)
                for a, change, z in zip(active, margins, step.limits, strict=True)
            )
        ),
    )


def _weighted_step(
    model: Model, active: Bounded, right: StageResiduals, free_start: int
) -> StageResiduals:
    """Solve with rows and active limits weighted rather than hard."""
    count, n, width = model.dynamics.shape
    size, dtype = width - n, model.gap.dtype
    weight = _WEIGHT * jnp.maximum(1.0, jnp.max(jnp.abs(model.hessian)))
    holds = Bounded(*(weight * flags for flags in active))
    of_states = jnp.concatenate([jnp.zeros((1, n), dtype), right.x[:-1]])
    limits = right.limits
    by_limits = holds.lower * limits.lower - holds.upper * limits.upper
    gradient = jnp.concatenate([-of_states, by_limits - right.u], axis=1)
    gradient = gradient + times(jnp.swapaxes(model.path_slope, 1, 2), holds.path * limits.path)
    hard = jnp.broadcast_to(weight, model.equality.shape)
    gradient = gradient - times(jnp.swapaxes(model.equality_slope, 1, 2), hard * right.equality)
    hessian = model.hessian + weighted(model.path_slope, holds.path)
    hessian = hessian + weighted(model.equality_slope, hard)
    diagonal = jnp.concatenate([jnp.zeros((count, n), dtype), holds.lower + holds.upper], axis=1)
    last = model.final_hessian + weighted(
        model.rows_slope, jnp.broadcast_to(weight, model.rows.shape)
    )
    last = last + weighted(model.final_slope, holds.final)
    pull = times(model.final_slope.T, holds.final * limits.final) - right.x[-1]
    pull = pull - times(model.rows_slope.T, weight * right.rows)
    free, forced, nothing = jnp.ones(size, dtype), jnp.zeros(size, dtype), jnp.zeros((), dtype)

    def backwards(value: Array, inputs: tuple[Array, ...]) -> tuple[Array, tuple[Array, Array]]:
        dynamics, hessian, diagonal, gradient, missed = inputs
        ahead = value[:, n] - jnp.sum(value[:, :n] * missed[None], axis=1)
        shifted = jnp.concatenate([value[:, :n], ahead[:, None]], axis=1)
        stage = StageModel(dynamics, hessian + jnp.diag(diagonal), gradient)
        policy = backward_step(shifted, stage, free, forced, nothing)
        return policy.value, (policy.law, value)

    inputs = (model.dynamics, hessian, diagonal, gradient, right.costates)
    end_value = jnp.concatenate([last, pull[:, None]], axis=1)
    value, (laws, valued) = lax.scan(backwards, end_value, inputs, reverse=True)
    first = jnp.zeros(n, dtype)
    begin = right.begin
    if free_start:
        by_first = value[:, n].at[n - free_start :].add(-right.begin)
        begin = eliminated(value[:, :n], by_first, n - free_start).law[:, -1]
        first = first.at[n - free_start :].set(begin)

    def forwards(x: Array, inputs: tuple[Array, ...]) -> tuple[Array, tuple[Array, Array]]:
        dynamics, law, missed = inputs
        u = law[:, n] + jnp.sum(law[:, :n] * x[None], axis=1)
        ahead = jnp.sum(dynamics * jnp.concatenate([x, u])[None], axis=1) - missed
        return ahead, (x, u)

    end, (x, u) = lax.scan(forwards, first, (model.dynamics, laws, right.costates))
    moved, ahead = jnp.concatenate([x, u], axis=1), jnp.concatenate([x[1:], end[None]])
    step = Bounded(
        times(model.path_slope, moved),
        times(model.final_slope, end),
        u,
        -u,
    )
    return StageResiduals(
        begin,
        ahead,
        u,
        valued[..., n] + times(valued[..., :n], ahead),
        weight * (times(model.equality_slope, moved) - right.equality),
        weight * (times(model.rows_slope, end) - right.rows),
        Bounded(
            *(
                jnp.where(flags, -weight * (ds + r), -r)
                for flags, ds, r in zip(active, step, limits, strict=True)
            )
        ),
    )
