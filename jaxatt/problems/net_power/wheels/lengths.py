"""Lengths that programmes of different manoeuvres share, so that few of them are compiled."""

from __future__ import annotations

_SHORT = (32, 64, 128)
_STEPS, _FINE_STEPS, _LONG = 4, 8, 1024
"""Lengths between two powers of two, and those from so many intervals on."""


def shared_length(intervals: int) -> int:
    """Least shared length that holds so many intervals.

    Longer ones are wider apart; what is filled up costs as much time as other intervals do.
    """
    for length in _SHORT:
        if intervals <= length:
            return length
    power = 1 << (intervals.bit_length() - 1)
    apart = power // (_FINE_STEPS if intervals >= _LONG else _STEPS)
    return -(-intervals // apart) * apart
