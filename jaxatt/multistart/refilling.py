"""Lanes that end make room for those that wait, so that the slowest does not rule a chunk.

A chunk advances a few passes at a time.  Between two times the host takes out the lanes that have
ended and puts waiting ones in their places; one that takes long stays where it is, beside others.
What a lane does depends on itself alone, so its result does not depend on its neighbours.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from jaxatt.simulation.chunks import Progress, first_time, pool, workers

Advance = Callable[[Any, Any, npt.NDArray[np.bool_]], tuple[Any, Any, Any]]
"""(lanes, states, fresh) -> (states, results, running).

lanes : with a leading axis of rows; looked at where something is fresh.  states, results : with a
trailing axis of rows.  fresh : (rows,), those whose state is to be made from their lane.
running : (rows,), those that have not ended.
"""


class _Chunk:
    """Rows that advance together.

    index : (rows,), the lane in every row.  busy, fresh : (rows,).
    """

    def __init__(self, empty: Any, rows: int):
        self.states = empty
        self.index = np.zeros(rows, int)
        self.busy = np.zeros(rows, bool)
        self.fresh = np.zeros(rows, bool)

    def fill(self, waiting: deque[int]) -> bool:
        """Put waiting lanes into free rows; False if there is nothing left to do."""
        for row in np.flatnonzero(~self.busy)[: len(waiting)]:
            self.index[row] = waiting.popleft()
            self.busy[row] = self.fresh[row] = True
        return bool(self.busy.any())

    def advanced(self, advance: Advance, lanes: Any) -> tuple[Any, npt.NDArray[np.bool_]]:
        """Results (..., rows), and whether a row is still running, after some passes."""
        some = jax.tree.map(lambda leaf: leaf[self.index], lanes)
        self.states, results, running = advance(some, self.states, self.fresh)
        self.fresh = np.zeros_like(self.fresh)
        return jax.tree.map(np.asarray, results), np.asarray(running)


def refilling(
    advance: Advance,
    lanes: Any,
    empty: Any,
    rows: int,
    progress: Progress | None = None,
    key: Hashable = None,
) -> Any:
    """Results of all lanes, a pytree with leading axis S, from `advance` until none is running.

    lanes : pytree with leading axis S.  empty : states of `rows` rows that are not running.
    key : what `advance` compiles for; the first chunk of a new key runs alone, or every thread
    would compile it.
    """
    lanes = jax.tree.map(np.asarray, lanes)
    count = len(jax.tree.leaves(lanes)[0])
    waiting = deque(range(count))
    gathered: Any = None

    def collect(chunk: _Chunk, found: tuple[Any, npt.NDArray[np.bool_]]) -> None:
        nonlocal gathered
        results, running = found
        if gathered is None:
            gathered = jax.tree.map(
                lambda leaf: np.empty((count, *leaf.shape[:-1]), leaf.dtype), results
            )
        ended = chunk.busy & ~running
        for into, leaf in zip(jax.tree.leaves(gathered), jax.tree.leaves(results), strict=True):
            into[chunk.index[ended]] = np.moveaxis(leaf[..., ended], -1, 0)
        chunk.busy &= running
        if progress is not None and ended.any():
            progress(int(ended.sum()))

    if progress is not None:
        progress(0)
    chunks = [_Chunk(empty, rows) for _ in range(workers())]
    if first_time(key, rows):
        chunks[0].fill(waiting)
        collect(chunks[0], chunks[0].advanced(advance, lanes))
    under_way: dict[Future[Any], _Chunk] = {}

    def send(chunk: _Chunk) -> None:
        if chunk.fill(waiting):
            under_way[pool().submit(chunk.advanced, advance, lanes)] = chunk

    for chunk in chunks:
        send(chunk)
    while under_way:
        for done in wait(under_way, return_when=FIRST_COMPLETED).done:
            chunk = under_way.pop(done)
            collect(chunk, done.result())
            send(chunk)
    return gathered
