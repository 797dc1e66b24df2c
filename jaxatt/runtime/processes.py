"""Rows of a batch that several processes share.

Every process runs the same programme on the host.  Rows of a batch, such as starts, are split among
the processes where they are solved or flown, and all results are gathered by all, so that what
follows is the same everywhere.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import jax
import numpy as np
import numpy.typing as npt
from jax.experimental.multihost_utils import process_allgather

from jaxatt.runtime.joining import JoinError, LostProcessError, several

Told = Callable[[int], None] | None
"""Called by the host with the number of rows that have just ended, if anybody listens."""

_DIGEST = 32
"""Bytes of the digest by which processes tell whether they do the same."""


def agree(on: Any, what: str) -> None:
    """Raise `JoinError` where another process holds something else, which messages call `what`."""
    if not several():
        return
    every = _gathered(np.frombuffer(_digest(on), np.uint8))
    other = np.flatnonzero((every != every[0]).any(axis=1))
    if len(other):
        raise JoinError(
            f"process {other[0]} has {what} than process 0; start all processes with the same "
            "command and code, on the same kind of machine"
        )


def shared(run: Callable[[Any, Told], Any], batch: Any, progress: Told = None) -> Any:
    """Apply `run` to the rows of a batch, each process to its share, and gather all results.

    run : from a pytree with leading axis rows, and a progress of its own, to another pytree; the
        result of a row depends on this row alone.
    batch : with leading axis S, the same in all processes.  Row i is in the share of process
        i // ceil(S / processes); shares are filled up with copies of row 0.
    progress : told of the own share as it ends, and of the others' when they are gathered.

    Raises `JoinError` where another process has other rows, `LostProcessError` where it has ended.
    """
    if not several():
        return run(batch, progress)
    processes = jax.process_count()
    agree(batch, "other starts")
    count = len(jax.tree.leaves(batch)[0])
    size = -(-count // processes)
    rows = np.arange(size) + size * jax.process_index()
    left = int((rows < count).sum())
    rows = np.where(rows < count, rows, 0)
    told = 0

    def ended(some: int) -> None:
        nonlocal told
        if progress is not None:
            some = min(some, left - told)  # copies do not count
            told += some
            progress(some)

    found = run(jax.tree.map(lambda leaf: np.asarray(leaf)[rows], batch), ended)
    leaves, tree = jax.tree.flatten(found)
    leaves = [np.ascontiguousarray(leaf) for leaf in leaves]
    every = _gathered(np.concatenate([leaf.reshape(-1).view(np.uint8) for leaf in leaves]))
    parts = np.split(every, np.cumsum([leaf.nbytes for leaf in leaves])[:-1], axis=1)
    if progress is not None:
        progress(count - told)

    def joined(part: npt.NDArray[np.uint8], like: npt.NDArray[Any]) -> npt.NDArray[Any]:
        all_rows = (processes * size, *like.shape[1:])
        return np.ascontiguousarray(part).view(like.dtype).reshape(all_rows)[:count]

    return jax.tree.unflatten(tree, [joined(*both) for both in zip(parts, leaves, strict=True)])


def _gathered(content: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Bytes of every process, (processes, bytes); all have as many."""
    # Lengths are powers of two, so that few programs are compiled.
    padded = np.zeros(max(_DIGEST, 1 << (len(content) - 1).bit_length()), np.uint8)
    padded[: len(content)] = content
    try:
        found: npt.NDArray[np.uint8] = np.asarray(process_allgather(padded))
    except (RuntimeError, ValueError) as error:  # what a broken connection is to JAX
        raise LostProcessError(f"another process has ended early ({error})") from error
    return found[:, : len(content)]


def _digest(of: Any) -> bytes:
    content = hashlib.blake2b(digest_size=_DIGEST)
    for leaf in map(np.asarray, jax.tree.leaves(of)):
        content.update(f"{leaf.dtype}{leaf.shape}".encode())
        content.update(np.ascontiguousarray(leaf).tobytes())
    return content.digest()
