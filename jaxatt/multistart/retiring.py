"""Lanes that take long are solved among themselves, so that the slowest does not rule a chunk."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from typing import Any

import jax
import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Progress, in_chunks

EARLY_ITERATIONS = 16
"""Most lanes of a polish have ended by then."""

Settings = Any


def retiring(
    run: Callable[[Any, Settings], Any],
    lanes: Any,
    settings: Settings,
    rows: int,
    progress: Progress | None,
    key: Hashable,
    together: bool = True,
    early: int | None = None,
) -> Any:
    """`run` on all lanes, chunk by chunk, so that the slowest does not rule.

    A chunk runs until its slowest lane ends.  So lanes that take long are retired after a few
    iterations and solved again among themselves, from their start, which changes no result.
    run, key, together : as in `in_chunks`; the solutions have a `status` and `iterations`.
    settings : a dataclass with `max_iterations`.  early : iterations before a lane is retired.
    """

    def solve_with(limit: int, some: Any, told: Progress | None) -> Any:
        limited = replace(settings, max_iterations=limit)
        return in_chunks(lambda chunk: run(chunk, limited), some, rows, told, key, together)

    limit = min(EARLY_ITERATIONS if early is None else early, settings.max_iterations)
    found = solve_with(limit, lanes, progress)
    unfinished = (found.status == Status.FEASIBLE) | (found.status == Status.ITERATION_LIMIT)
    slow = np.flatnonzero(unfinished & (found.iterations >= limit))
    if limit == settings.max_iterations or not len(slow):
        return found
    late = solve_with(settings.max_iterations, jax.tree.map(lambda leaf: leaf[slow], lanes), None)

    def merged(early: Floats, later: Floats) -> Floats:
        early[slow] = later
        return early

    return jax.tree.map(merged, found, late)
