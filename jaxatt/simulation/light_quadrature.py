"""Weights that integrate a power over the steps of a flight, with the light of every instant.

The light depends on time alone, and may jump; what it shines on is smooth.  So within a part of a
step the power per unit of light is a line through two Gauss points, and the light is integrated
with it: exactly where it is constant, by a fine midpoint rule where it changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from jaxatt.runtime.arrays import Floats

_POINTS = np.array([0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0])
"""Of Gauss on an interval of length one."""

_PART, _MOST = 0.025, 8
"""Longest part of a step [s], as far as that many parts allow."""

_JUMP = 0.05
"""Change of light within a part beyond which its instants are looked at one by one."""
_FINE, _COARSE = 1024, 16
"""Points of the midpoint rule in a part, with a jump and without."""

Light = Callable[[Floats], Floats]
"""Times (n,) [s] -> visible fraction of the sun (n,)."""


def parts_for(step: float) -> int:
    """Number of equal parts of a step [s], with two Gauss points each."""
    return max(1, min(_MOST, math.ceil(step / _PART - 1e-9)))


def shares_of(points: int) -> Floats:
    """Gauss points of a step with so many of them, in shares of it."""
    parts = points // 2
    found: Floats = ((np.arange(float(parts))[:, None] + _POINTS) / parts).ravel()
    return found


def light_weights(light: Light, seen: Floats, start: float, step: float, parts: int) -> Floats:
    """Weights (steps, 2 parts) [s] of the Gauss points of every step.

    light : the exact one.  seen : (2 steps + 1,), the same at the ends and middles of all steps,
    where a change within a step shows.  start : [s], of the first step.  step : [s].
    parts : of a step, `parts_for`.
    """
    middles = seen[1::2]
    weights = np.repeat(step / (2 * parts) * middles[:, None], 2 * parts, axis=1)
    rows = np.flatnonzero((seen[:-1:2] != middles) | (seen[2::2] != middles))
    if rows.size:
        first: Floats = start + step * rows.astype(float)
        weights[rows] = _changing(light, first, step, parts)
    return weights


def _changing(light: Light, first: Floats, step: float, parts: int) -> Floats:
    """Weights (m, 2 parts) [s] of steps within which the light changes; they begin at (m,) [s]."""
    part = step / parts
    edges: Floats = first[:, None] + part * np.arange(parts + 1.0)
    seen = np.asarray(light(edges.ravel())).reshape(edges.shape)
    weights = np.repeat(0.5 * part * seen[:, :-1, None], 2, axis=2)
    change = np.abs(np.diff(seen, axis=1))
    for changing, points in (
        ((change > 0.0) & (change <= _JUMP), _COARSE),
        (change > _JUMP, _FINE),
    ):
        if changing.any():
            begin: Floats = edges[:, :-1][changing]
            weights[changing] = _resolved(light, begin, part, points)
    return weights.reshape(len(first), 2 * parts)


def _resolved(light: Light, first: Floats, part: float, points: int) -> Floats:
    """Weights (m, 2) [s] of parts that begin at (m,) [s]."""
    within = (np.arange(points) + 0.5) / points
    times: Floats = (first[:, None] + part * within).ravel()
    seen = np.asarray(light(times)).reshape(-1, points)
    # The straight lines that are one at their own Gauss point and zero at the other.
    late = (within - _POINTS[0]) / (_POINTS[1] - _POINTS[0])
    basis = np.stack([1.0 - late, late], axis=1)
    return part / points * seen @ basis
