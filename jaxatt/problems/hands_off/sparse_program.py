"""Programmes of sparse control for any system: maximum hands-off, moving hands-off and L1.

A system brings the rows that must vanish at the end, its path constraints and its control limits;
this module adds the objective.  Nothing here knows of spacecraft.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.equations import Equations
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.program import Program
from jaxatt.optimize.root_program import RootProgram
from jaxatt.problems.hands_off import sparsity


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SparseArguments:
    """Arguments of a sparse control programme.

    plant : pytree of the system's own parameters.
    weight : (N,), h_k of the moving hands-off objective (5.5); ones otherwise.
    free : (N, b), 1 where torque is allowed: windows that forbid it and a frozen support are zeros.
    count_scale, effort_scale : () factors of the two parts of the objective.
    price : (N,), what effort costs in each interval, in units of effort_scale, where a support
        settles; ones unless intervals compete by it.
    effort_map : (r, b), the quantities whose absolute values make up the L1 effort.
    row_weight : (m,), inf for terminal rows that are constraints; the weight w of w/2 row^2 for
        rows that belong to the printed cost.
    """

    plant: Any
    weight: Array
    free: Array
    count_scale: Array
    effort_scale: Array
    price: Array
    effort_map: Array
    row_weight: Array


class DecidedBy(StrEnum):
    """Methods that decide the support of a system's controls, or settle on a given one."""

    CONDENSED = "reweighted Newton steps on the rows at the end"
    STAGES = "reweighted Riccati steps, interval by interval"
    BOUNDS = "reweighted steps between bounds"
    LAGRANGIAN = "the augmented Lagrangian"


@dataclass(frozen=True)
class SparseSystem:
    """A controlled system, in scaled controls u (N, b).

    rows : (u, plant) -> (m,), terminal and waypoint errors.
    margins : (u, plant) -> (p,), path constraints, non-negative when satisfied.
    stage_margins : (u, plant) -> (N, q), control limits, non-negative when satisfied.
    turned : (plant, sign) -> plant, aimed at the target the short (1) or the long (-1) way round.
    aimed : (plant, target) -> plant, aimed at another target, where starts have their own.
    stretched : (plant, ratio) -> plant, with intervals `ratio` times as long.
    lengthened : (plant, more) -> plant, filled up with so many intervals in which nothing happens,
        so that tasks of several lengths share a program; None where that is not supported.
    response : (u, plant) -> (m,) and (N, m, b), the errors that `rows` measures, in any smooth
        measure that vanishes where they do, and their derivatives; None where path constraints
        rule out a search that does not know them.
    equations : (u, weights, moved, accurate, plant) -> the same errors, linearised for a weighted
        step with derivatives that are nearly right; None where `response` is as cheap.
    limits : plant -> (n, b), rows l of the control limits |l u[k]| <= 1.
    bounds : plant -> (b,) and (b,), limits lower <= u[k] <= upper that each control has of its own;
        given instead of `limits` where controls are one-sided, as thrusters are.
    path : (u, plant) -> (K,) and (N, K, b), path constraints where they are worst, non-negative
        when satisfied, and their derivatives, for systems with `bounds`; None without any.
    decided_by : how supports are decided, unless the caller wants another way.
    label : the same words in every process for what compiles to the same, so that programs can be
        kept; None where they are not.
    stages : number of controls b -> the same system interval by interval, without cost and
        without the control limits, its arguments `SparseArguments`; None where it has no such form.
    """

    rows: Callable[[Array, Any], Array]
    margins: Callable[[Array, Any], Array]
    stage_margins: Callable[[Array, Any], Array]
    turned: Callable[[Any, Array], Any] = lambda plant, sign: plant
    stretched: Callable[[Any, Array], Any] = lambda plant, ratio: replace(
        plant, step=plant.step * ratio
    )
    lengthened: Callable[[Any, int], Any] | None = None
    aimed: Callable[[Any, Array], Any] = lambda plant, target: plant
    response: Callable[[Array, Any], tuple[Array, Array]] | None = None
    equations: Callable[[Array, Array, Array, Array, Any], Equations] | None = None
    limits: Callable[[Any], Array] | None = None
    bounds: Callable[[Any], tuple[Array, Array]] | None = None
    path: Callable[[Any, Any], tuple[Array, Array]] | None = None
    stages: Callable[[int], OptimalControlProgram] | None = None
    decided_by: DecidedBy = DecidedBy.LAGRANGIAN
    label: str | None = None


@functools.cache
def sparse_program(system: SparseSystem, shared: bool) -> Program:
    """Programme of a sparse control problem.

    shared : whether all controls of an interval count as one (design 1) or each for itself
    (designs 2 and 3, eqs. 5.14 and 5.15).
    """

    def objective(u: Array, args: SparseArguments, smoothing: Array) -> Array:
        count = sparsity.log_count(u, args.weight, smoothing, shared)
        effort = sparsity.absolute_effort(u @ args.effort_map.T, smoothing)
        return args.count_scale * count + args.effort_scale * effort

    def curvature(u: Array, args: SparseArguments, smoothing: Array) -> Array:
        count = sparsity.log_count_curvature(u, args.weight, smoothing, shared)
        effort = sparsity.absolute_effort_curvature(u @ args.effort_map.T, smoothing)
        size = u.shape[1]
        diagonal = jnp.eye(size, dtype=u.dtype)[None] * count[:, :, None]
        mapped = jnp.einsum("kr,ri,rj->kij", effort, args.effort_map, args.effort_map)
        return args.count_scale * diagonal + args.effort_scale * mapped

    return Program(
        objective=objective,
        curvature=curvature,
        equality=lambda u, args: system.rows(u, args.plant),
        equality_weight=lambda u, args: args.row_weight,
        inequality=lambda u, args: system.margins(u, args.plant),
        stage_inequality=lambda u, args: system.stage_margins(u, args.plant),
        free=lambda u, args: args.free,
    )


@functools.cache
def sparse_roots(system: SparseSystem, shared: bool) -> RootProgram:
    """The rows of a system that few controls are to bring to zero."""
    response, equations, path = system.response, system.equations, system.path
    limits, bounds = system.limits, system.bounds
    return RootProgram(
        free=lambda args: args.free,
        importance=lambda args: args.weight * args.count_scale,
        row_weight=lambda args: args.row_weight,
        response=response and (lambda u, args: response(u, args.plant)),
        equations=equations
        and (
            lambda u, weights, moved, exact, args: equations(u, weights, moved, exact, args.plant)
        ),
        path=path and (lambda u, args: path(u, args.plant)),
        limits=limits and (lambda args: limits(args.plant)),
        bounds=bounds and (lambda args: bounds(args.plant)),
        shared=shared or bounds is not None,
    )


@functools.cache
def sparse_effort(system: SparseSystem, shared: bool) -> RootProgram:
    """The same rows, to be brought to zero with the least effort."""
    return replace(
        sparse_roots(system, shared),
        effort_map=lambda args: args.effort_map,
        effort_scale=lambda args: args.effort_scale * args.price,
    )


def with_slacks(u: Array, shared: bool) -> Array:
    """Controls (..., N, b) with their slacks |u| beside them, for `slack_program`."""
    size = jnp.abs(u)
    slack = jnp.max(size, axis=-1, keepdims=True) if shared else size
    return jnp.concatenate([u, slack], axis=-1)


@functools.cache
def slack_program(system: SparseSystem, shared: bool) -> Program:
    """Programme of the L1 problem with slacks s: minimise the sum of s with -s <= u <= s.

    The variables of an interval are its b controls, then one slack for all of them (5.7), or one
    for each (3.20) where `shared` is false.  The objective is linear, so the smoothing enters as
    curvature alone: it keeps the Newton step bounded and does not move the optimum.
    """

    def controls(x: Array) -> Array:
        size = x.shape[1] - 1 if shared else x.shape[1] // 2
        return x[:, :size]

    def slacks(x: Array) -> Array:
        return x[:, controls(x).shape[1] :]

    def stage_inequality(x: Array, args: SparseArguments) -> Array:
        u, s = controls(x), slacks(x)
        return jnp.concatenate([system.stage_margins(u, args.plant), s - u, s + u], axis=1)

    def curvature(x: Array, args: SparseArguments, smoothing: Array) -> Array:
        eye = jnp.eye(x.shape[1], dtype=x.dtype)[None]
        return args.effort_scale * smoothing * jnp.repeat(eye, x.shape[0], axis=0)

    return Program(
        objective=lambda x, args, smoothing: args.effort_scale * jnp.sum(slacks(x)),
        curvature=curvature,
        equality=lambda x, args: system.rows(controls(x), args.plant),
        equality_weight=lambda x, args: args.row_weight,
        inequality=lambda x, args: system.margins(controls(x), args.plant),
        stage_inequality=stage_inequality,
        free=lambda x, args: jnp.concatenate([args.free, jnp.ones_like(slacks(x))], axis=1),
    )
