"""Programme of sparse control for systems in stages."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.root_program import RootProgram
from jaxatt.problems.hands_off import sparsity
from jaxatt.problems.hands_off.sparse_program import SparseArguments, SparseSystem

Sparse = tuple[Any, Array, Array]
"""What the system has at a stage, the weight of an active interval () and what is free (b,)."""


def _inner(function: Any) -> Any:
    """The same function, applied to the system's part of the stage."""
    return lambda x, u, stage, args: function(x, u, stage[0], args)


@functools.cache
def sparse_stages(
    system: SparseSystem, size: int, shared: bool, limited: bool = True
) -> OptimalControlProgram:
    """Programme of a sparse control problem in stages of `size` controls.

    shared : whether all controls of an interval count as one (design 1) or each for itself.
    limited : whether the control limits become inequalities of the stages, or are left out.
    """
    build, limits = system.stages, system.limits
    assert build is not None and limits is not None
    base = build(size)
    n = base.error_size

    def stages(args: SparseArguments) -> Sparse:
        return base.stages(args), args.weight, args.free

    def cost(x: Array, u: Array, stage: Sparse, args: SparseArguments, smoothing: Array) -> Array:
        count = sparsity.log_count(u[None], stage[1][None], smoothing, shared)
        mapped = jnp.sum(args.effort_map * u[None], axis=1)
        effort = sparsity.absolute_effort(mapped, smoothing)
        return args.count_scale * count + args.effort_scale * effort

    def curvature(
        x: Array, u: Array, stage: Sparse, args: SparseArguments, smoothing: Array
    ) -> Array:
        count = sparsity.log_count_curvature(u[None], stage[1][None], smoothing, shared)[0]
        mapped = jnp.sum(args.effort_map * u[None], axis=1)
        effort = sparsity.absolute_effort_curvature(mapped, smoothing)
        block = args.count_scale * count[:, None] * jnp.eye(size, dtype=u.dtype)
        rows = args.effort_map
        spent = jnp.sum(effort[:, None, None] * rows[:, :, None] * rows[:, None, :], axis=0)
        return jnp.pad(block + args.effort_scale * spent, ((n, 0), (n, 0)))

    def inequality(x: Array, u: Array, stage: Sparse, args: SparseArguments) -> Array:
        path = base.inequalities(x, u, stage[0], args)
        if not limited:
            return path
        relative = jnp.sum(limits(args.plant) * u[None], axis=1)
        return jnp.concatenate([path, 1.0 - relative, 1.0 + relative])

    def equality_weight(stage: Sparse, args: SparseArguments) -> Array:
        return base.equality_weights(stage[0], args)

    def linearise(x: Array, u: Array, x_next: Array, stage: Sparse, args: Any) -> Array:
        return base.derivatives(x, u, x_next, stage[0], args)

    return replace(
        base,
        stages=stages,
        dynamics=_inner(base.dynamics),
        cost=cost,
        curvature=curvature,
        equality=None if base.equality is None else _inner(base.equality),
        equality_weight=None if base.equality_weight is None else equality_weight,
        inequality=inequality if limited or base.inequality is not None else None,
        free=lambda stage, args: stage[2],
        linearise=linearise,
    )


@functools.cache
def sparse_stage_roots(system: SparseSystem, size: int, shared: bool) -> RootProgram:
    """The rows of a system, interval by interval, that few controls are to bring to zero."""
    limits = system.limits
    assert limits is not None
    return RootProgram(
        free=lambda args: args.free,
        importance=lambda args: args.weight * args.count_scale,
        row_weight=lambda args: args.row_weight,
        stages=sparse_stages(system, size, shared, limited=False),
        limits=lambda args: limits(args.plant),
        shared=shared,
    )
