"""Solve many starts of a reorientation by the interior-point method, in chunks of one size."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax

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
from jaxatt.problems.time_optimal.parameters import ReorientationParameters
from jaxatt.problems.time_optimal.random_paths import Paths
from jaxatt.problems.time_optimal.reorientation import ReorientationForm, reorientation
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report, chunk_for
from jaxatt.runtime.settings import QUICK_TO_COMPILE

_PASSES = 4
"""Of a chunk between two looks for starts that have ended."""
_ROWS = 32
"""At most in a chunk on a CPU: the last start that takes long keeps few idle ones busy."""


class _Own(NamedTuple):
    """What a start has of its own for as long as it is solved; see `Paths`."""

    step: Floats
    reference: Floats
    effort_weight: Floats


def _placed(lane: Paths | _Own, arguments: ReorientationParameters) -> ReorientationParameters:
    return replace(
        arguments,
        step=jnp.asarray(lane.step),
        reference=jnp.asarray(lane.reference),
        effort_weight=jnp.asarray(lane.effort_weight),
    )


@functools.partial(jax.jit, static_argnames=("form", "size"), compiler_options=QUICK_TO_COMPILE)
def _advance_chunk(
    form: ReorientationForm,
    size: int,
    lanes: Paths,
    states: State,
    fresh: npt.NDArray[np.bool_],
    arguments: ReorientationParameters,
    settings: InteriorSettings,
) -> tuple[State, InteriorSolution, Array]:
    """Some passes for a chunk of starts; see `refilling.Advance`."""
    program = reorientation(form, size)

    # The rows go last, where every component becomes one contiguous vector.
    def trailing(lanes: Any) -> Any:
        return jax.tree.map(lambda leaf: jnp.moveaxis(jnp.asarray(leaf), 0, -1), lanes)

    def renewed(states: State) -> State:
        def one(lane: Paths, state: State, new: Array) -> State:
            u, x = jnp.asarray(lane.u), jnp.asarray(lane.states)
            first = begin(program, u, x, _placed(lane, arguments), settings)
            return jax.tree.map(lambda a, b: jnp.where(new, a, b), first, state)

        new = jnp.asarray(fresh)
        return jax.vmap(one, in_axes=-1, out_axes=-1)(trailing(lanes), states, new)

    def one(lane: _Own, state: State) -> tuple[State, InteriorSolution, Array]:
        placed = _placed(lane, arguments)
        state = advance(program, state, placed, settings, _PASSES)
        return state, outcome(state, settings), running(state, settings)

    states = lax.cond(jnp.any(fresh), renewed, lambda states: states, states)
    own = trailing(_Own(lanes.step, lanes.reference, lanes.effort_weight))
    return jax.vmap(one, in_axes=-1, out_axes=-1)(own, states)


def _rows(count: int) -> int:
    rows = chunk_for(count)
    return min(rows, _ROWS) if jax.default_backend() == "cpu" else rows


def solve_paths(
    task: ReorientationTask,
    paths: Paths,
    settings: InteriorSettings | None = None,
    arguments: ReorientationParameters | None = None,
    report: Report | None = None,
    rows: int | None = None,
) -> InteriorSolution:
    """Solve a task from all of its starts, chunk by chunk, and gather the results on the host.

    arguments : in place of the task's own.  rows : starts in one compiled call.
    """
    settings = settings or InteriorSettings()
    arguments = arguments or task.parameters
    rows = rows or _rows(len(paths.u))
    progress = None if report is None else lambda done: report("solving from all starts", done)

    def some_passes(
        lanes: Paths, states: State, fresh: npt.NDArray[np.bool_]
    ) -> tuple[State, InteriorSolution, Array]:
        form, size = task.form, task.actuation.size
        return _advance_chunk(form, size, lanes, states, fresh, arguments, settings)

    def started(lane: Paths) -> State:
        placed = _placed(lane, arguments)
        return begin(task.program, jnp.asarray(lane.u), jnp.asarray(lane.states), placed, settings)

    shapes = jax.eval_shape(started, jax.tree.map(lambda leaf: leaf[0], paths))
    empty = jax.tree.map(lambda leaf: np.zeros((*leaf.shape, rows), leaf.dtype), shapes)
    key = ("reorientation", task.form, paths.u.shape[1:])
    return refilling(some_passes, paths, empty, rows, progress, key)
