"""Longer intervals, each of several of a manoeuvre's own, for the first search of a long one.

They are short at both ends, where the satellite turns, and grow with the distance from there.
"""

from __future__ import annotations

import itertools

import numpy as np

from jaxatt.runtime.arrays import Counts, Floats

_SIDE = 400
"""Intervals of the manoeuvre from either end over which they grow to their full length, at most."""
_LEAST_GROWTH = 0.05
"""Length of one over its distance from the nearer end, at least."""


def longer_intervals(intervals: int, most: int) -> Counts:
    """Lengths (M,), M <= most, of the longer intervals, in intervals of the manoeuvre.

    As short as `most` allows.
    """
    for longest in itertools.count(1):
        lengths = _lengths(intervals, longest)
        if len(lengths) <= most:
            break
    return lengths


def _lengths(intervals: int, longest: int) -> Counts:
    """The same with none that is longer than `longest`."""
    half, growth = intervals // 2, max(_LEAST_GROWTH, longest / _SIDE)
    side: list[int] = []
    passed = 0
    while passed < half:
        length = min(longest, max(1, int(growth * passed)), half - passed)
        side.append(length)
        passed += length
    middle = [1] * (intervals % 2)
    return np.array([*side, *middle, *side[::-1]])


def at_nodes(weights: Floats, nodes: Counts) -> Floats:
    """Weights (N + 1,) of the hat functions of all nodes, on some of them (M + 1,).

    nodes : (M + 1,), which; the first and the last are among them.
    """
    every = np.arange(len(weights))
    behind = np.clip(np.searchsorted(nodes, every, side="right") - 1, 0, len(nodes) - 2)
    share = (every - nodes[behind]) / (nodes[behind + 1] - nodes[behind])
    found = np.zeros(len(nodes))
    np.add.at(found, behind, (1.0 - share) * weights)
    np.add.at(found, behind + 1, share * weights)
    return found


def averaged(values: Floats, held: Counts) -> Floats:
    """Means (S, M, c) over longer intervals of values (S, N, c)."""
    first = np.cumsum(held) - held
    means: Floats = np.add.reduceat(values, first, axis=1) / held[:, None]
    return means
