"""Split a batch of any length into chunks of one compiled size, and run them on all cores.

Where there are several processes, each runs the chunks of its share.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import numpy as np

from jaxatt.runtime.processes import shared

CHUNK = 64
"""Rows in one compiled call; 32 to 128 are fastest on a core."""

ACCELERATOR_CHUNK = 4096
"""The same on a GPU or TPU, which one chunk must fill."""

Progress = Callable[[int], None]
"""Called by the host with the number of rows that have just ended."""

Report = Callable[[str, int], None]
"""(stage, starts that have just ended), called by the host between chunks."""


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def workers() -> int:
    """Number of chunks that run side by side in this process.

    One a core where JAX runs programs in the thread that calls them, see `jaxatt.runtime.settings`;
    one a device otherwise.
    """
    inline = not jax.config.read("jax_cpu_enable_async_dispatch")  # type: ignore[no-untyped-call]
    cpu = jax.default_backend() == "cpu"
    return cores() if inline and cpu else 1 if cpu else jax.local_device_count()


def share_of(count: int) -> int:
    """Rows of a batch of `count` for each of the chunks that run side by side in all processes."""
    return -(-count // (workers() * jax.process_count()))


def chunk_for(count: int) -> int:
    """Chunk size for a batch of `count`: a power of two, small enough to use every core."""
    most = CHUNK if jax.default_backend() == "cpu" else ACCELERATOR_CHUNK
    share = share_of(count)
    return min(most, max(8, 1 << (share - 1).bit_length()))


def rows_of_flights(count: int) -> int:
    """Chunk size for `count` flights.

    Eight take as long each as 64 do, and little longer than one alone, so that one, few and many
    share a program; a call of it takes its time too, which counts where there are very many.
    """
    few = count <= 4 * CHUNK and jax.default_backend() == "cpu"
    return 8 if few else CHUNK


def padded_chunks(batch: Any, rows: int = CHUNK) -> Iterator[tuple[Any, int]]:
    """Split a pytree of arrays along their leading axis into chunks of `rows` rows.

    The last chunk is filled up with copies of its first row.  Yields each chunk with the number
    of rows in it that count.
    """
    total = len(jax.tree.leaves(batch)[0])
    for first in range(0, total, rows):
        chunk = jax.tree.map(lambda leaf, k=first: np.asarray(leaf)[k : k + rows], batch)
        size = min(rows, total - first)
        if size < rows:
            chunk = jax.tree.map(
                lambda leaf, k=size: np.concatenate([leaf, np.repeat(leaf[:1], rows - k, 0)]),
                chunk,
            )
        yield chunk, size


@functools.cache
def _pool(count: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(count, thread_name_prefix="jaxatt")


def pool() -> ThreadPoolExecutor:
    """Thread pool with one thread for each chunk that runs side by side."""
    return _pool(workers())


_compiled: set[Hashable] = set()


def first_time(key: Hashable, rows: int) -> bool:
    """Whether this key and number of rows run for the first time; None always counts as new."""
    new = key is None or (key, rows) not in _compiled
    _compiled.add((key, rows))
    return new


def in_chunks(
    run: Callable[[Any], Any],
    batch: Any,
    rows: int = CHUNK,
    progress: Progress | None = None,
    key: Hashable = None,
    together: bool = True,
) -> Any:
    """Apply `run` to all rows of a batch, chunk by chunk, and gather the results on the host.

    batch : with leading axis S, the same in all processes, and so is what is returned.
    run : from a pytree with leading axis `rows` to another; compiled, so that it leaves the
    interpreter free while it works: chunks run side by side, one a core.
    key : what `run` compiles for; the first chunk of a new key runs alone, or every thread would
    compile it.
    together : False where `run` calls LAPACK: such programs take turns, because side by side they
    can wait for ever for each other's threads.
    """

    def own(share: Any, progress: Progress | None) -> Any:
        return _own_chunks(run, share, rows, progress, key, together)

    return shared(own, batch, progress)


def _own_chunks(
    run: Callable[[Any], Any],
    batch: Any,
    rows: int,
    progress: Progress | None,
    key: Hashable,
    together: bool,
) -> Any:
    """As `in_chunks`, for the share of this process."""
    parts = list(padded_chunks(batch, rows))
    alone = int(first_time(key, rows)) if together else len(parts)
    gathered = []

    def one(part: tuple[Any, int]) -> Any:
        chunk, size = part
        return jax.tree.map(lambda leaf: np.asarray(leaf)[:size], run(chunk))

    def collect(found: Any, size: int) -> None:
        gathered.append(found)
        if progress is not None:
            progress(size)

    if progress is not None:
        progress(0)
    for part in parts[:alone]:
        collect(one(part), part[1])
    rest = parts[alone:]
    # Where there is one for every core, this thread takes one: waking another takes its time.
    mine = rest[-1:] if len(rest) <= workers() else []
    others = rest[: len(rest) - len(mine)]
    under_way = [pool().submit(one, part) for part in others]
    own = [one(part) for part in mine]
    for running, part in zip(under_way, others, strict=True):
        collect(running.result(), part[1])
    for found, part in zip(own, mine, strict=True):
        collect(found, part[1])
    return jax.tree.map(lambda *leaves: np.concatenate(leaves), *gathered)
