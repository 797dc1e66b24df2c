"""Chunks of one size, so that a batch of any length compiles once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import jax
import numpy as np

CHUNK = 64
"""Rows in one compiled call; 64 to 256 are fastest on a CPU of two cores."""


def chunk_for(count: int) -> int:
    """Rows a chunk for a search of `count` starts: a power of two, 8 to `CHUNK`."""
    return min(CHUNK, max(8, 1 << (count - 1).bit_length()))


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
