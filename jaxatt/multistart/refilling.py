"""Batched driver that replaces finished starts by waiting ones, so that no chunk idles.

A chunk advances a few passes at a time.  Between two times its thread takes out the lanes that have
ended and puts waiting ones in their places; one that takes long stays where it is, beside others.
What a lane does depends on itself alone, so its result does not depend on its neighbours.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Hashable
from typing import Any

import jax
import numpy as np
import numpy.typing as npt

from jaxatt.runtime.chunks import Progress, first_time, pool, workers

Advance = Callable[[Any, Any, npt.NDArray[np.bool_]], tuple[Any, Any, Any]]
"""(lanes, states, fresh) -> (states, results, running).

lanes, results : with a leading axis of rows.  states : whatever the next call gets.
fresh : (rows,), those whose state is to be made from their lane.
running : (rows,), those that have not ended.
"""


class _Lanes:
    """Queue of all lanes, and their results; it is shared by the threads of all chunks."""

    def __init__(self, lanes: Any, progress: Progress | None):
        self.lanes = jax.tree.map(np.asarray, lanes)
        self.count = len(jax.tree.leaves(self.lanes)[0])
        self.waiting = deque(range(self.count))
        self.progress = progress
        self.results: Any = None
        self.lock = threading.Lock()
        if progress is not None:
            progress(0)

    def take(self, most: int) -> list[int]:
        """Take up to `most` waiting lanes."""
        with self.lock:
            return [self.waiting.popleft() for _ in range(min(most, len(self.waiting)))]

    def put(self, index: npt.NDArray[np.int64], results: Any) -> None:
        """Store the results of lanes, rows first."""
        with self.lock:
            if self.results is None:
                self.results = jax.tree.map(
                    lambda leaf: np.empty((self.count, *leaf.shape[1:]), leaf.dtype), results
                )
            for into, leaf in zip(
                jax.tree.leaves(self.results), jax.tree.leaves(results), strict=True
            ):
                into[index] = leaf
            if self.progress is not None and len(index):
                self.progress(len(index))


class _Chunk:
    """A chunk of lanes that advance together.

    index : (rows,), the lane in every row.  busy, fresh : (rows,).
    order : (rows,), in which they are filled.
    """

    def __init__(self, advance: Advance, empty: Any, rows: int, shards: int):
        self.advance, self.states = advance, empty
        self.order = np.arange(rows).reshape(shards, -1).T.ravel()
        self.index = np.zeros(rows, int)
        self.busy = np.zeros(rows, bool)
        self.fresh = np.zeros(rows, bool)

    def step(self, lanes: _Lanes) -> bool:
        """Fill free rows, advance some iterations and store finished lanes; False when all are
        done.
        """
        free = self.order[~self.busy[self.order]]
        taken = lanes.take(len(free))
        self.fresh[:] = False
        self.fresh[free[: len(taken)]] = self.busy[free[: len(taken)]] = True
        self.index[free[: len(taken)]] = taken
        if not self.busy.any():
            return False
        some = jax.tree.map(lambda leaf: leaf[self.index], lanes.lanes)
        self.states, results, running = self.advance(some, self.states, self.fresh)
        ended = self.busy & ~np.asarray(running)
        if ended.any():
            self.hand_in(lanes, ended, results)
        return True

    def hand_in(self, lanes: _Lanes, ended: npt.NDArray[np.bool_], results: Any) -> None:
        """Store the results of rows that have ended, and free the rows."""
        lanes.put(
            self.index[ended],
            jax.tree.map(lambda leaf: np.asarray(leaf)[ended], results),
        )
        self.busy &= ~ended

    def run(self, lanes: _Lanes) -> None:
        """Advance until no lane is left."""
        while self.step(lanes):
            pass


def refilling(
    advance: Advance,
    lanes: Any,
    empty: Any,
    rows: int,
    progress: Progress | None = None,
    key: Hashable = None,
    together: bool = True,
    shards: int = 1,
) -> Any:
    """Advance all lanes until none is running, and return their results with leading axis S.

    lanes : pytree with leading axis S.  empty : states of `rows` rows that are not running.
    progress : called in turn by the threads that run the chunks.
    key : what `advance` compiles for; the first chunk of a new key runs alone, or every thread
    would compile it.
    together : False where chunks cannot run side by side.
    shards : devices that have an equal part of the rows each, and get as many lanes.
    """
    shared = _Lanes(lanes, progress)
    most = max(1, workers() // shards) if together else 1
    side_by_side = min(most, -(-shared.count // rows))
    chunks = [_Chunk(advance, empty, rows, shards) for _ in range(side_by_side)]
    if first_time(key, rows):
        chunks[0].step(shared)
    # A chunk stays with its thread, this one included: to wake one for every few passes takes time.
    others = [pool().submit(chunk.run, shared) for chunk in chunks[1:]]
    try:
        chunks[0].run(shared)
    except BaseException:
        shared.waiting.clear()  # an interrupted search is not solved on behind the user's back
        raise
    for other in others:
        other.result()
    return shared.results
