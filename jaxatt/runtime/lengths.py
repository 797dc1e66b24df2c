"""Lengths that programmes of different manoeuvres share, so that few of them are compiled."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

_LEAST, _LONG, _STEPS = 64, 1024, 8
"""Shortest length; lengths are powers of two up to the second, then so many between two powers."""


def shared_length(intervals: int, long: int = _LONG) -> int:
    """Least shared length that holds so many intervals.

    long : power of two up to which lengths are powers of two.

    What is filled up costs as much time as other intervals do: less than the compilation that it
    spares where programmes are short, and where they are long, lengths are closer together.
    """
    if intervals <= long:
        return max(_LEAST, 1 << (intervals - 1).bit_length())
    apart = (1 << (intervals.bit_length() - 1)) // _STEPS
    return -(-intervals // apart) * apart


def rounded_up(count: int, apart: int) -> int:
    """Least multiple of `apart` that holds so many steps."""
    return -(-count // apart) * apart


def held_on(rows: Any, more: int, axis: int = 0) -> Any:
    """Arrays of a pytree with their last row along an axis repeated `more` times."""

    def longer(leaf: Any) -> np.ndarray:
        along = np.asarray(leaf)
        last = np.take(along, [-1], axis)
        return np.concatenate([along, np.repeat(last, more, axis)], axis)

    return jax.tree.map(longer, rows)
