"""Solve many starts in chunks of one compiled size."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.augmented_lagrangian import Schedule, Solution, solve
from jaxatt.optimize.inner import inner_minimiser
from jaxatt.problems.hands_off import SparseArguments, SparseSystem, sparse_program
from jaxatt.problems.task import Floats
from jaxatt.simulation.chunks import padded_chunks

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


@functools.partial(jax.jit, static_argnames=("system", "shared", "inner"))
def _solve_chunk(
    system: SparseSystem,
    shared: bool,
    inner: str,
    lanes: Lanes,
    arguments: SparseArguments,
    schedule: Schedule,
) -> Solution:
    program = sparse_program(system, shared)

    def one(lane: Lanes) -> Solution:
        arg = replace(
            arguments,
            plant=system.turned(arguments.plant, lane.sign),
            free=lane.free,
            row_weight=lane.row_weight,
        )
        return solve(program, jnp.asarray(lane.u), arg, schedule, inner_minimiser(inner))

    return jax.vmap(one)(lanes)


def solve_lanes(
    system: SparseSystem,
    shared: bool,
    lanes: Lanes,
    arguments: SparseArguments,
    schedule: Schedule,
    inner: str = "gauss-newton",
    progress: Progress | None = None,
) -> Solution:
    """Solve all lanes, chunk by chunk, and gather the results on the host."""
    parts = []
    for chunk, size in padded_chunks(lanes):
        solution = _solve_chunk(system, shared, inner, chunk, arguments, schedule)
        parts.append(jax.tree.map(lambda leaf, size=size: np.asarray(leaf)[:size], solution))
        if progress is not None:
            progress(size)
    return jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)


def broadcast_lanes(u: Floats, free: Array | Floats, row_weight: Array | Floats, sign) -> Lanes:
    """Lanes from starts (S, N, b) and whatever is common to all of them."""
    count = len(u)
    return Lanes(
        u,
        np.broadcast_to(np.asarray(free), u.shape),
        np.broadcast_to(np.asarray(row_weight), (count, np.shape(row_weight)[-1])),
        np.broadcast_to(np.asarray(sign, float), (count,)),
    )
