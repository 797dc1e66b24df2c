"""Lengths that programmes of different manoeuvres share, so that few of them are compiled."""

from __future__ import annotations

_LEAST, _LONG, _STEPS = 64, 1024, 8
"""Shortest length; lengths are powers of two up to the second, then so many between two powers."""


def shared_length(intervals: int) -> int:
    """Least shared length that holds so many intervals.

    What is filled up costs as much time as other intervals do: less than the compilation that it
    spares where programmes are short, and where they are long, lengths are closer together.
    """
    if intervals <= _LONG:
        return max(_LEAST, 1 << (intervals - 1).bit_length())
    apart = (1 << (intervals.bit_length() - 1)) // _STEPS
    return -(-intervals // apart) * apart
