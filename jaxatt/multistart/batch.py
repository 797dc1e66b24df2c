"""Solve many starts in chunks of one compiled size."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.augmented_lagrangian import Schedule, Solution, solve
from jaxatt.optimize.inner import inner_minimiser
from jaxatt.problems.hands_off import (
    SparseArguments,
    SparseSystem,
    slack_program,
    sparse_program,
    with_slacks,
)
from jaxatt.problems.program import Program
from jaxatt.problems.task import Floats
from jaxatt.simulation.chunks import CHUNK, padded_chunks

Progress = Callable[[int], None]
"""Called by the host with the number of starts that have just ended."""


class Lanes(NamedTuple):
    """What differs from start to start; leading axis S.

    u : (S, N, b).  free : (S, N, b).  row_weight : (S, m).  sign : (S,).
    """

    u: Floats
    free: Floats
    row_weight: Floats
    sign: Floats


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


@functools.partial(jax.jit, static_argnames=("form",))
def _solve_chunk(
    form: Form, lanes: Lanes, arguments: SparseArguments, schedule: Schedule
) -> Solution:
    inner = inner_minimiser(form.inner)

    def one(lane: Lanes) -> Solution:
        arg = replace(
            arguments,
            plant=form.system.turned(arguments.plant, jnp.asarray(lane.sign)),
            free=jnp.asarray(lane.free),
            row_weight=jnp.asarray(lane.row_weight),
        )
        u = jnp.asarray(lane.u)
        if not form.slacks:
            return solve(form.program, u, arg, schedule, inner)
        solution = solve(form.program, with_slacks(u, form.shared), arg, schedule, inner)
        return solution._replace(x=solution.x[:, : u.shape[1]])

    return jax.vmap(one)(lanes)


def solve_lanes(
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    schedule: Schedule,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> Solution:
    """Solve all lanes, chunk by chunk of `rows`, and gather the results on the host."""
    parts = []
    if progress is not None:
        progress(0)
    for chunk, size in padded_chunks(lanes, rows):
        solution = _solve_chunk(form, chunk, arguments, schedule)
        parts.append(jax.tree.map(lambda leaf, size=size: np.asarray(leaf)[:size], solution))
        if progress is not None:
            progress(size)
    return jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)


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
