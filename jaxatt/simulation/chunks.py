"""Chunks of one size, so that a batch of any length compiles once."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import jax
import numpy as np

CHUNK = 64
"""Rows in one compiled call; 64 to 256 are fastest on a CPU of two cores."""


def padded_chunks(batch: Any) -> Iterator[tuple[Any, int]]:
    """Split a pytree of arrays along their leading axis into chunks of `CHUNK` rows.

    The last chunk is filled up with copies of its first row.  Yields each chunk with the number
    of rows in it that count.
    """
    total = len(jax.tree.leaves(batch)[0])
    for first in range(0, total, CHUNK):
        chunk = jax.tree.map(lambda leaf, k=first: np.asarray(leaf)[k : k + CHUNK], batch)
        size = min(CHUNK, total - first)
        if size < CHUNK:
            chunk = jax.tree.map(
                lambda leaf, k=size: np.concatenate([leaf, np.repeat(leaf[:1], CHUNK - k, 0)]),
                chunk,
            )
        yield chunk, size
