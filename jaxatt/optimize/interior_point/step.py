"""Newton step over all stages by one Riccati recursion and a forward sweep."""

from __future__ import annotations

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.interior_point.crossover import Pairs
from jaxatt.optimize.interior_point.model import Bounded, Model
from jaxatt.optimize.interior_point.recursion import Stages, solved
from jaxatt.optimize.lanes import in_lanes

_LEAST_PIVOT = 1e-11
_MANY_ROWS = 8
"""From more rows on a product of matrices is faster than a sum of rank-one products."""


class Step(NamedTuple):
    """A step of all primal and dual variables.

    x : (N, n) and end : (n,), errors of the states.  u : (N, b).
    equality : (N, q) and rows : (r,), of multipliers.  costates : (N, n), after the step.
    slack, dual : of the inequalities.
    convex : (), whether the model was, on what the dynamics leave free; otherwise it is no step.
    """

    x: Array
    end: Array
    u: Array
    equality: Array
    rows: Array
    slack: Bounded
    dual: Bounded
    costates: Array
    convex: Array


def weighted(slope: Array, weight: Array) -> Array:
    """Product slope' diag(weight) slope, (..., z, z)."""
    if slope.shape[-2] > _MANY_ROWS:
        return jnp.swapaxes(slope, -1, -2) @ (weight[..., None] * slope)
    shape = (*slope.shape[:-2], slope.shape[-1], slope.shape[-1])
    total = jnp.zeros(shape, slope.dtype)
    for k in range(slope.shape[-2]):
        row = slope[..., k, :]
        total = total + (weight[..., k, None] * row)[..., :, None] * row[..., None, :]
    return total


def times(slope: Array, vector: Array) -> Array:
    """Matrix-vector product over the last axes."""
    return jnp.sum(slope * vector[..., None, :], axis=-1)


def newton_step(
    model: Model,
    slack: Bounded,
    dual: Bounded,
    pairs: Pairs,
    row_penalty: Array,
    free_start: int,
    shift: Array,
    integrals: int = 0,
) -> Step:
    """Newton step towards a stationary point at which every pair obeys its relation.

    slack : what is left to every limit.  row_penalty : (), of the hard rows, see `interior_point`.
    shift : (), added to all curvature, save that of `integrals`, see `OptimalControlProgram`: they
    move far for a good step, and have no curvature that could be missing.
    """
    count, n, width = model.dynamics.shape
    dtype = model.gap.dtype
    stiffness, intercept = pairs
    # Excess of the inequalities over their slacks; those of the controls' limits are exact.
    path_excess, final_excess = model.path - slack.path, model.final - slack.final
    diagonal = stiffness.lower + stiffness.upper
    by_limits = intercept.upper - intercept.lower
    at_path = dual.path - intercept.path + stiffness.path * path_excess
    at_end = dual.final - intercept.final + stiffness.final * final_excess
    gradient = jnp.concatenate([jnp.zeros((count, n), dtype), model.gradient[:, n:] + by_limits], 1)
    gradient = gradient + jnp.sum(model.path_slope * at_path[..., None], axis=1)
    hessian = model.hessian + weighted(model.path_slope, stiffness.path)
    if model.equality.shape[-1]:
        pulled = row_penalty * model.equality
        gradient = gradient + jnp.sum(model.equality_slope * pulled[..., None], axis=1)
        weight = jnp.broadcast_to(row_penalty, model.equality.shape)
        hessian = hessian + weighted(model.equality_slope, weight)
    diagonal = jnp.concatenate([jnp.zeros((count, n), dtype), diagonal], axis=1)
    last = model.final_hessian + weighted(
        model.rows_slope, jnp.broadcast_to(row_penalty, model.rows.shape)
    )
    last = last + weighted(model.final_slope, stiffness.final)
    pull = jnp.sum(model.rows_slope * (row_penalty * model.rows)[:, None], axis=0)
    pull = pull + jnp.sum(model.final_slope * at_end[:, None], axis=0)
    end_value = jnp.concatenate([last, pull[:, None]], axis=1)
    curved = jnp.ones(width, dtype).at[n - free_start - integrals : n - free_start].set(0.0)
    shifted = diagonal + (shift * curved)[None]
    curving = hessian + shifted[..., None] * jnp.eye(width, dtype=dtype)[None]
    stages = Stages(model.dynamics, curving, gradient, model.gap)
    recursion = in_lanes(functools.partial(solved, free_start=free_start))
    x, end, u, costates, least = recursion(stages, end_value, model.costate)
    moved = jnp.concatenate([x, u], axis=1)
    costates = model.costates + costates
    slack_step = Bounded(
        times(model.path_slope, moved) + path_excess,
        times(model.final_slope, end) + final_excess,
        u,
        -u,
    )
    dual_step = jax.tree.map(
        lambda a, z, q, ds: a - z - q * ds, intercept, dual, stiffness, slack_step
    )
    rows = row_penalty * (model.rows + times(model.rows_slope, end))
    equality = row_penalty * (model.equality + times(model.equality_slope, moved))
    return Step(x, end, u, equality, rows, slack_step, dual_step, costates, least > _LEAST_PIVOT)
