"""Solve a programme over stages from many starts at once by the interior-point method."""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from jaxatt.multistart.programs.starts import ProgramStarts
from jaxatt.multistart.refilling import refilling
from jaxatt.optimize.interior_point.solver import (
    InteriorSettings,
    InteriorSolution,
    State,
    advance,
    begin,
    outcome,
    running,
)
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.runtime.arrays import Flags
from jaxatt.runtime.chunks import Progress, chunk_for
from jaxatt.runtime.settings import QUICK_TO_COMPILE

_PASSES = 4
"""Of a chunk between two looks for starts that have ended."""
_MEMORY = 8e6
"""[bytes] Of a chunk's derivatives, so that they stay near the core."""
_COPIES = 10
"""Matrices of the size of a stage's Hessian that a stage has at a time."""
_LEAST, _MOST = 8, 32


@functools.partial(jax.jit, static_argnames=("program",), compiler_options=QUICK_TO_COMPILE)
def _advance_chunk(
    program: OptimalControlProgram,
    lanes: ProgramStarts,
    states: State,
    fresh: Flags,
    args: Any,
    settings: InteriorSettings,
) -> tuple[State, InteriorSolution, Array]:
    """Some passes for a chunk of starts; see `refilling.Advance`."""

    def renewed(states: State) -> State:
        def one(lane: ProgramStarts, state: State, new: Array) -> State:
            first = begin(program, jnp.asarray(lane.u), jnp.asarray(lane.x), args, settings)
            return jax.tree.map(lambda a, b: jnp.where(new, a, b), first, state)

        # The rows go last, where every component becomes one contiguous vector.
        trailing = jax.tree.map(lambda leaf: jnp.moveaxis(jnp.asarray(leaf), 0, -1), lanes)
        return jax.vmap(one, in_axes=-1, out_axes=-1)(trailing, states, jnp.asarray(fresh))

    def one(state: State) -> tuple[State, InteriorSolution, Array]:
        state = advance(program, state, args, settings, _PASSES)
        return state, outcome(state, settings), running(state, settings)

    states = lax.cond(jnp.any(fresh), renewed, lambda states: states, states)
    return jax.vmap(one, in_axes=-1, out_axes=-1)(states)


def _rows(program: OptimalControlProgram, starts: ProgramStarts) -> int:
    """Starts in one compiled call: as many as keep the derivatives near the core."""
    count, intervals, size = starts.u.shape
    rows = chunk_for(count)
    if jax.default_backend() != "cpu":
        return rows
    a_start = 8.0 * _COPIES * intervals * (program.error_size + size) ** 2
    fitting = 1 << max(0, int(np.log2(_MEMORY / a_start)))
    return min(rows, max(_LEAST, min(_MOST, fitting)))


def solve_starts(
    program: OptimalControlProgram,
    starts: ProgramStarts,
    args: Any,
    settings: InteriorSettings,
    progress: Progress | None = None,
) -> InteriorSolution:
    """Solve from all starts, chunk by chunk, and gather the results on the host, leading axis S."""
    rows = _rows(program, starts)

    def some_passes(
        lanes: ProgramStarts, states: State, fresh: Flags
    ) -> tuple[State, InteriorSolution, Array]:
        return _advance_chunk(program, lanes, states, fresh, args, settings)

    def started(lane: ProgramStarts) -> State:
        return begin(program, jnp.asarray(lane.u), jnp.asarray(lane.x), args, settings)

    shapes = jax.eval_shape(started, jax.tree.map(lambda leaf: leaf[0], starts))
    empty = jax.tree.map(lambda leaf: np.zeros((*leaf.shape, rows), leaf.dtype), shapes)
    key = ("programme", program, starts.u.shape[1:], jax.tree.structure(args))
    return refilling(some_passes, starts, empty, rows, progress, key)
