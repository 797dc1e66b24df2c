"""Switching times of torques between their limits."""

from __future__ import annotations

import itertools

import numpy as np

from jaxatt.runtime.arrays import Floats

_SATURATED = 1e-3
"""Share of the half range within which a torque counts as at its limit."""


def switch_times(torque: Floats, edges: Floats, lower: Floats, upper: Floats) -> tuple[Floats, ...]:
    """Times [s] at which each torque changes from one of its limits to the other.

    torque : (N, b) [N m], constant in the intervals between edges (N + 1,) [s].
    lower, upper : (b,) [N m].

    Between the limits the instant is the one at which a jump would give the same impulse, so that
    a switch is known better than the length of an interval.
    """
    scaled = (2.0 * torque - upper - lower) / (upper - lower)
    found = []
    for values in scaled.T:
        side = np.where(np.abs(values) > 1.0 - _SATURATED, np.sign(values), 0.0)
        at_limit = np.flatnonzero(side)
        times = []
        for before, after in itertools.pairwise(at_limit):
            if side[before] == side[after]:
                continue
            between = slice(before + 1, after)
            kept = (values[between] - side[after]) / (side[before] - side[after])
            lengths = np.diff(edges)[between]
            times.append(float(edges[before + 1] + np.sum(kept * lengths)))
        found.append(np.array(times))
    return tuple(found)
