"""Solve many starts by Riccati steps, in chunks of one compiled size."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.multistart.retiring import retiring
from jaxatt.optimize.augmented_lagrangian.solver import Schedule
from jaxatt.optimize.reweighting.condensed import Reweighting, SparseRoot
from jaxatt.optimize.reweighting.staged import StagedReweighting, sparsify_stages
from jaxatt.optimize.riccati.lagrangian import StagedSolution, solve_stages
from jaxatt.problems.hands_off.search.batch import Form, Lanes, placed
from jaxatt.problems.hands_off.sparse_program import SparseArguments
from jaxatt.problems.hands_off.sparse_stages import sparse_stages
from jaxatt.runtime.chunks import CHUNK, Progress, in_chunks


def _batched(one: Callable[[Lanes], Any], lanes: Lanes) -> Any:
    # The batch axis goes last, where every component becomes one contiguous vector.
    last = jax.tree.map(lambda leaf: jnp.moveaxis(jnp.asarray(leaf), 0, -1), lanes)
    found = jax.vmap(one, in_axes=-1, out_axes=-1)(last)
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), found)


@functools.partial(jax.jit, static_argnames=("form",))
def _solve_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, schedule: Schedule
) -> StagedSolution:
    program = sparse_stages(form.system, lanes.u.shape[-1], form.shared)

    def one(lane: Lanes) -> StagedSolution:
        return solve_stages(program, lane.u, placed(form, lane, arguments), schedule)

    solution: StagedSolution = _batched(one, lanes)
    return solution


@functools.partial(jax.jit, static_argnames=("form",))
def _sparsify_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, settings: StagedReweighting
) -> SparseRoot:
    program = sparse_stages(form.system, lanes.u.shape[-1], form.shared, limited=False)
    limits = form.system.limits
    assert limits is not None

    def one(lane: Lanes) -> SparseRoot:
        arg = placed(form, lane, arguments)
        importance: Array = arg.weight * arg.count_scale
        return sparsify_stages(
            program, limits(arg.plant), lane.u, arg.free, importance, form.shared, arg, settings
        )

    root: SparseRoot = _batched(one, lanes)
    return root


def solve_staged_lanes(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    schedule: Schedule,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> StagedSolution:
    """As `batch.solve_lanes`, by the augmented Lagrangian with Riccati steps."""
    run = functools.partial(_solve_chunk, form)
    key = ("solve stages", form, lanes.u.shape[1:])
    return retiring(
        lambda chunk, limited: run(chunk, arguments, limited), lanes, schedule, rows, progress, key
    )


def sparsify_staged_lanes(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    settings: Reweighting,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> SparseRoot:
    """As `batch.sparsify_lanes`, with Riccati steps; path constraints included."""
    run = functools.partial(_sparsify_chunk, form)
    key = ("sparsify stages", form, lanes.u.shape[1:])
    chosen = StagedReweighting(settings)
    return in_chunks(lambda chunk: run(chunk, arguments, chosen), lanes, rows, progress, key)
