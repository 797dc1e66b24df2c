"""Neighbouring supports, for a local search over which intervals are active."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

Mask = npt.NDArray[np.bool_]

_ALL_POSITIONS_UP_TO = 6
"""Active entries up to which every position is tried; beyond, only the adjacent ones."""


def neighbours(support: Mask, allowed: Mask) -> list[Mask]:
    """Supports with one active entry dropped or moved to another interval.

    support, allowed : (N, g), g groups an interval; a group moves in its own column only.
    """
    active = [tuple(entry) for entry in np.argwhere(support)]
    intervals = support.shape[0]
    far = len(active) <= _ALL_POSITIONS_UP_TO
    found: list[Mask] = []
    for k, group in active:
        dropped = support.copy()
        dropped[k, group] = False
        if dropped.any():
            found.append(dropped)
        places = range(intervals) if far else (k - 1, k + 1)
        for place in places:
            inside = 0 <= place < intervals
            if inside and allowed[place, group] and not support[place, group]:
                moved = dropped.copy()
                moved[place, group] = True
                found.append(moved)
    return found


def mergers(support: Mask, allowed: Mask, most: int) -> list[Mask]:
    """Supports with two active entries dropped and one let in anywhere, so one fewer in all.

    support, allowed : (N, g).  most : supports, spread evenly over all there are.
    """
    pairs = list(itertools.combinations(np.argwhere(support), 2))
    places = np.argwhere(allowed & ~support)
    total = len(pairs) * len(places)
    found: list[Mask] = []
    for index in np.unique(np.linspace(0, total - 1, min(most, total)).round().astype(int)):
        one, other = pairs[index // len(places)]
        merged = support.copy()
        merged[*one] = merged[*other] = False
        merged[*places[index % len(places)]] = True
        found.append(merged)
    return found
