"""Batched driver that runs many starts of one problem with any solver.

Starts are solved in chunks of one compiled size, one a core, the batch axis where the solver is
fastest.  Those that end make room for those that wait (`refilling`), and none is begun anew; where
all starts take the same number of passes a chunk runs to the end in one call instead.  Several
devices have a part of the rows each (`sharding`), several processes a share of the starts
(`jaxatt.runtime.processes`).  What a start does depends on itself alone.
"""

from __future__ import annotations

import functools
from collections.abc import Hashable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt
from jax import Array, lax
from jax.sharding import Mesh

from jaxatt.multistart.refilling import refilling
from jaxatt.multistart.sharding import ROWS, WHOLE, own_devices, parted, placed, rows_along
from jaxatt.optimize.solver import Solver, refuse, solve
from jaxatt.runtime.chunks import Progress, chunk_for
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.processes import shared

_WORKING_COPIES = 16
"""Memory that a pass takes for a start, in states: derivatives, trial points, what XLA keeps."""

_CPU_BYTES = 1 << 29
"""Memory that one chunk may take on a CPU."""

_DEVICE_SHARE = 0.5
"""Share of an accelerator's memory that one chunk may take."""


class Problem(Protocol):
    """Static part of a problem; equal ones, by `==` and `hash`, share compiled programs."""

    @property
    def program(self) -> Any:
        """Programme for the solver."""

    @property
    def label(self) -> str | None:
        """Label for `jaxatt.runtime.compilation`; None for programs that are not kept."""

    def enter(self, start: Any, args: Any) -> tuple[Any, Any]:
        """Initial point for the solver, and the arguments of this start."""


@dataclass(frozen=True)
class Plain:
    """A programme whose starts differ only in their initial point."""

    program: Any
    label: str | None = None

    def enter(self, start: Any, args: Any) -> tuple[Any, Any]:
        """The start itself, and the arguments that all starts share."""
        return start, args


@dataclass(frozen=True)
class Job:
    """A problem as a static argument of a `Routine`.

    lapack : whether its solver calls LAPACK, on a CPU; such programs are not kept, because tracing
        sets it up, and run on one device.
    mesh : the devices that share a chunk; None for one.
    """

    problem: Problem
    lapack: bool
    mesh: Mesh | None

    @property
    def label(self) -> str | None:
        """Label for `jaxatt.runtime.compilation`; None for programs that are not kept."""
        return None if self.lapack or self.mesh is not None else self.problem.label

    @property
    def devices(self) -> int:
        """How many devices share a chunk."""
        return 1 if self.mesh is None else self.mesh.size


def _job(solver: Solver, problem: Problem) -> Job:
    lapack = solver.calls_lapack and jax.default_backend() == "cpu"
    return Job(problem, lapack, None if lapack else own_devices())


@functools.partial(Routine, statics=1)
def to_the_end(job: Job, starts: Any, args: Any, solver: Solver) -> Any:
    """Run a chunk of starts that all take the same number of passes to their results.

    The leading axis is rows.
    """
    run = functools.partial(_to_the_end, job)
    return parted(job.mesh, run, (ROWS, WHOLE, WHOLE), ROWS)(starts, args, solver)


def _to_the_end(job: Job, starts: Any, args: Any, solver: Solver) -> Any:
    axis = solver.batch_axis

    def one(start: Any) -> Any:
        guess, own = job.problem.enter(start, args)
        return solve(solver, job.problem.program, guess, own)

    # What all starts share stays one value, such as the count of passes: a branch on it is taken or
    # not, where in a `_Chunk` both sides would be computed in every pass.
    found = jax.vmap(one, in_axes=axis, out_axes=axis)(_to(axis, starts))
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, axis, 0), found)


@dataclass(frozen=True)
class _Chunk:
    """A chunk of starts, their batch axis where the solver has it.

    The loop is around the batch: `jax.vmap` of a loop traces its body several times.
    """

    problem: Problem
    solver: Solver
    starts: Any
    args: Any

    def begun(self) -> Any:
        """States before the first pass."""

        def one(start: Any) -> Any:
            return self.solver.init(self.problem.program, *self.problem.enter(start, self.args))

        return self._each(one)(self.starts)

    def running(self, states: Any) -> Array:
        """Whether each start goes on, (rows,)."""
        return ~self._each(self.solver.done)(states)

    def advanced(self, states: Any, passes: int) -> Any:
        """Advance all that are running by some passes at most."""
        solver, program = self.solver, self.problem.program

        def going(carry: tuple[Any, Array]) -> Array:
            return jnp.any(self.running(carry[0])) & (carry[1] < passes)

        def one(start: Any, state: Any) -> Any:
            ahead = solver.step(program, state, self.problem.enter(start, self.args)[1])
            ended = solver.done(state)
            return jax.tree.map(lambda new, old: jnp.where(ended, old, new), ahead, state)

        def onward(carry: tuple[Any, Array]) -> tuple[Any, Array]:
            return self._each(one)(self.starts, carry[0]), carry[1] + 1

        return lax.while_loop(going, onward, (states, jnp.asarray(0)))[0]

    def results(self, states: Any) -> Any:
        """Results of all starts."""

        def one(start: Any, state: Any) -> Any:
            own = self.problem.enter(start, self.args)[1]
            return self.solver.result(self.problem.program, state, own)

        return self._each(one)(self.starts, states)

    def _each(self, function: Any) -> Any:
        axis = self.solver.batch_axis
        return jax.vmap(function, in_axes=axis, out_axes=axis)


@functools.partial(Routine, statics=1)
def some_passes(
    job: Job, starts: Any, states: Any, fresh: Array, args: Any, solver: Solver
) -> tuple[Any, Any, Array]:
    """Advance a chunk of starts by some passes; see `refilling.Advance`."""
    along = rows_along(solver.batch_axis, states)
    run, takes = functools.partial(_some_passes, job), (ROWS, along, ROWS, WHOLE, WHOLE)
    found: tuple[Any, Any, Array] = parted(job.mesh, run, takes, (along, ROWS, ROWS))(
        starts, states, fresh, args, solver
    )
    return found


def _some_passes(
    job: Job, starts: Any, states: Any, fresh: Array, args: Any, solver: Solver
) -> tuple[Any, Any, Array]:
    axis, fresh = solver.batch_axis, jnp.asarray(fresh)
    chunk = _Chunk(job.problem, solver, _to(axis, starts), args)

    def renewed(states: Any) -> Any:
        def one(new: Array, first: Any, state: Any) -> Any:
            return jax.tree.map(lambda a, b: jnp.where(new, a, b), first, state)

        return jax.vmap(one, (0, axis, axis), axis)(fresh, chunk.begun(), states)

    states = lax.cond(jnp.any(fresh), renewed, lambda states: states, states)
    was_running = chunk.running(states)
    states = chunk.advanced(states, solver.passes)
    running = chunk.running(states)
    ended = (was_running | fresh) & ~running
    shapes = jax.eval_shape(chunk.results, states)
    nothing = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), shapes)
    found = lax.cond(jnp.any(ended), chunk.results, lambda _: nothing, states)
    found = jax.tree.map(lambda leaf: jnp.moveaxis(leaf, axis, 0), found)
    # A weak type would be another program for the next call.
    states = jax.tree.map(lambda leaf: lax.convert_element_type(leaf, leaf.dtype), states)
    return states, found, running


def run_starts(
    solver: Solver,
    problem: Problem,
    starts: Any,
    args: Any,
    *,
    rows: int | None = None,
    progress: Progress | None = None,
) -> Any:
    """Run all starts and gather their results on the host, leading axis S.

    starts : pytree with leading axis S.  args : pytree that all starts share.
    rows : starts in one compiled call on each device; by default as many as the cores or the
        accelerators want, and never more than fit into memory.
    progress : called by the host with the number of starts that have just ended.

    Where there are several processes, all call this alike; each solves its share, and all get all
    results.

    Raises ValueError, before anything is compiled, where the solver does not support the programme.
    """
    refuse(solver, problem.program)
    count = len(jax.tree.leaves(starts)[0])
    state = _state(solver, problem, starts, args)
    rows = _fitting(chunk_for(count) if rows is None else rows, state)

    def own(share: Any, progress: Progress | None) -> Any:
        return _run_own(solver, problem, share, args, state, rows, progress)

    return shared(own, starts, progress)


def _run_own(
    solver: Solver,
    problem: Problem,
    starts: Any,
    args: Any,
    state: Any,
    rows: int,
    progress: Progress | None,
) -> Any:
    """As `run_starts`, for the share of this process; state : shapes of one start's."""
    job = _job(solver, problem)
    rows = rows * job.devices
    key = (job, *_types(starts), *_types(solver))
    how = (rows, progress, key, not job.lapack, job.devices)
    if solver.same_passes:

        def ended(some: Any, states: Any, fresh: npt.NDArray[np.bool_]) -> tuple[Any, Any, Any]:
            return states, to_the_end(job, some, args, solver), np.zeros(len(fresh), bool)

        return refilling(ended, starts, (), *how)

    def passes(some: Any, states: Any, fresh: npt.NDArray[np.bool_]) -> tuple[Any, Any, Any]:
        return some_passes(job, some, states, fresh, args, solver)

    return refilling(passes, starts, _empty(solver, state, rows, job), *how)


def begin_compiling(
    pool: Executor, solver: Solver, problem: Problem, starts: Any, args: Any, rows: int
) -> None:
    """Compile ahead, in a thread of `pool`, what `run_starts` will call for such starts."""
    state = _state(solver, problem, starts, args)
    job = _job(solver, problem)
    rows = _fitting(rows, state) * job.devices
    some = jax.tree.map(lambda leaf: np.zeros((rows, *leaf.shape[1:]), leaf.dtype), starts)
    if solver.same_passes:
        to_the_end.begin(pool, job, some, args, solver)
    else:
        empty, fresh = _empty(solver, state, rows, job), np.zeros(rows, bool)
        some_passes.begin(pool, job, some, empty, fresh, args, solver)


def _to(axis: int, starts: Any) -> Any:
    return jax.tree.map(lambda leaf: jnp.moveaxis(jnp.asarray(leaf), 0, axis), starts)


_states: dict[Hashable, Any] = {}
"""Shapes of states that were asked for before: tracing takes longer than many a chunk."""


def _state(solver: Solver, problem: Problem, starts: Any, args: Any) -> Any:
    """Shapes of the state of one start."""

    def first(start: Any, args: Any, solver: Solver) -> Any:
        return solver.init(problem.program, *problem.enter(start, args))

    one = jax.tree.map(lambda leaf: leaf[0], starts)
    leaves, tree = jax.tree.flatten((one, args, solver))
    kinds = [(np.shape(leaf), getattr(leaf, "dtype", type(leaf))) for leaf in leaves]
    key = (problem, tree, *kinds)
    if key not in _states:
        _states[key] = jax.eval_shape(first, one, args, solver)
    return _states[key]


def _empty(solver: Solver, state: Any, rows: int, job: Job) -> Any:
    """States of rows that are not running, on the devices of the next call."""

    def batch(leaf: Any) -> Any:
        shape = (rows, *leaf.shape) if solver.batch_axis == 0 else (*leaf.shape, rows)
        return np.zeros(shape, leaf.dtype)

    states = jax.tree.map(batch, state)
    return placed(job.mesh, states, rows_along(solver.batch_axis, states))


def _fitting(rows: int, state: Any) -> int:
    """Number of rows, reduced to what fits into memory."""
    one = sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(state))
    most = _chunk_bytes() // max(1, _WORKING_COPIES * one)
    return rows if rows <= most else max(1, 1 << (int(most).bit_length() - 1))


def _chunk_bytes() -> int:
    device = jax.local_devices()[0]
    if device.platform == "cpu":
        return _CPU_BYTES
    about = device.memory_stats() or {}
    return int(_DEVICE_SHARE * about.get("bytes_limit", 1 << 33))


def _types(of: Any) -> tuple[Hashable, ...]:
    """Key that tells compiled programs apart, whatever the number of starts."""
    leaves, tree = jax.tree.flatten(of)
    return (tree, *(np.shape(leaf)[1:] for leaf in leaves))
