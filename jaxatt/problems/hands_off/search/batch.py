"""Solve many starts in chunks of one compiled size."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.multistart.retiring import retiring
from jaxatt.optimize.augmented_lagrangian.inner import inner_minimiser
from jaxatt.optimize.augmented_lagrangian.solver import Schedule, Solution, solve
from jaxatt.optimize.least_effort.primal_dual import least_effort
from jaxatt.optimize.program import Program
from jaxatt.optimize.reweighting.condensed import Reweighting, SparseRoot, sparsify
from jaxatt.problems.hands_off.sparse_program import (
    SparseArguments,
    SparseSystem,
    slack_program,
    sparse_program,
    with_slacks,
)
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import CHUNK, Progress, in_chunks
from jaxatt.runtime.compilation import Routine


class Lanes(NamedTuple):
    """What differs from start to start; leading axis S.

    u : (S, N, b).  free : (S, N, b).  row_weight : (S, m).  sign : (S,).
    """

    u: Any
    free: Any
    row_weight: Any
    sign: Any


@dataclass(frozen=True)
class Form:
    """What is compiled in.

    system : the controlled system.  shared : whether an interval's controls count as one.
    slacks : whether the L1 problem with slacks is solved, otherwise the sparse one.
    inner : name of the inner minimiser.
    """

    system: SparseSystem
    shared: bool
    slacks: bool = False
    inner: str = "gauss-newton"

    @property
    def program(self) -> Program:
        """The programme that the solver gets."""
        build = slack_program if self.slacks else sparse_program
        return build(self.system, self.shared)

    @property
    def label(self) -> str | None:
        """See `jaxatt.runtime.compilation`; None for systems that have none."""
        if self.system.label is None:
            return None
        return repr((self.system.label, self.shared, self.slacks, self.inner))


def placed(form: Form, lane: Lanes, arguments: SparseArguments) -> SparseArguments:
    """Arguments of one lane."""
    return replace(
        arguments,
        plant=form.system.turned(arguments.plant, lane.sign),
        free=lane.free,
        row_weight=lane.row_weight,
    )


@functools.partial(Routine, statics=1, kept=False)
def solve_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, schedule: Schedule
) -> Solution:
    inner = inner_minimiser(form.inner)

    def one(lane: Lanes) -> Solution:
        arg, u = placed(form, lane, arguments), lane.u
        if not form.slacks:
            return solve(form.program, u, arg, schedule, inner)
        solution = solve(form.program, with_slacks(u, form.shared), arg, schedule, inner)
        return solution._replace(x=solution.x[:, : u.shape[1]])

    return jax.vmap(one)(jax.tree.map(jnp.asarray, lanes))


@functools.partial(Routine, statics=1)
def sparsify_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, settings: Reweighting
) -> SparseRoot:
    limits = form.system.limits
    assert limits is not None

    def one(lane: Lanes) -> SparseRoot:
        plant = form.system.turned(arguments.plant, lane.sign)
        return sparsify(
            form.system.linearise(plant),
            limits(plant),
            lane.u,
            lane.free,
            arguments.weight * arguments.count_scale,
            lane.row_weight,
            form.shared,
            settings,
        )

    # The batch axis goes last, where every component becomes one contiguous vector.
    last = jax.tree.map(lambda leaf: jnp.moveaxis(jnp.asarray(leaf), 0, -1), lanes)
    found = jax.vmap(one, in_axes=-1, out_axes=-1)(last)
    return jax.tree.map(lambda leaf: jnp.moveaxis(leaf, -1, 0), found)


@functools.partial(Routine, statics=1)
def effort_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, schedule: Schedule
) -> Solution:
    respond, limits = form.system.response, form.system.limits
    assert respond is not None and limits is not None

    def one(lane: Lanes) -> Solution:
        plant = form.system.turned(arguments.plant, lane.sign)
        return least_effort(
            lambda u: respond(u, plant),
            limits(plant),
            arguments.effort_map,
            lane.u,
            lane.free,
            lane.row_weight,
            arguments.effort_scale,
            schedule,
        )

    return jax.vmap(one)(jax.tree.map(jnp.asarray, lanes))


def solve_lanes(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    schedule: Schedule,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> Solution:
    """Solve all lanes by the augmented Lagrangian and gather the results on the host."""
    run = functools.partial(solve_chunk, form)
    key = ("solve", form, lanes.u.shape[1:])
    return retiring(
        lambda chunk, limited: run(chunk, arguments, limited),
        lanes,
        schedule,
        rows,
        progress,
        key,
        together=False,
    )


def spend_least(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    schedule: Schedule,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> Solution:
    """Least effort on frozen supports, as `solve_lanes` but for tasks with a `response` only."""
    run = functools.partial(effort_chunk, form)
    key = ("effort", form, lanes.u.shape[1:])
    return retiring(
        lambda chunk, limited: run(chunk, arguments, limited), lanes, schedule, rows, progress, key
    )


def sparsify_lanes(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    settings: Reweighting,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> SparseRoot:
    """Bring all lanes' rows to zero with few controls and gather the results on the host."""
    run = functools.partial(sparsify_chunk, form)
    key = ("sparsify", form, lanes.u.shape[1:])
    return in_chunks(lambda chunk: run(chunk, arguments, settings), lanes, rows, progress, key)


def broadcast_lanes(
    u: Floats, free: Array | Floats, row_weight: Array | Floats, sign: Floats
) -> Lanes:
    """Lanes from starts (S, N, b) and whatever is common to all of them."""
    count = len(u)
    return Lanes(
        u,
        np.broadcast_to(np.asarray(free), u.shape),
        np.broadcast_to(np.asarray(row_weight), (count, np.shape(row_weight)[-1])),
        np.broadcast_to(np.asarray(sign, float), (count,)),
    )
