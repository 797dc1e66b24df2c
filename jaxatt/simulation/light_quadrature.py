"""Weights that integrate a power over the steps of a flight, with the light of every instant.

The light depends on time alone, and may jump; what it shines on is smooth.  So within a step the
power per unit of light is a polynomial through the Gauss points, and the light is integrated with
it: exactly where it is constant, by a fine midpoint rule where it changes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jaxatt.runtime.arrays import Floats

_POINT = 0.5 - np.sqrt(3.0) / 6.0
SHARES = np.array([0.5 * _POINT, 0.5 - 0.5 * _POINT, 0.5 + 0.5 * _POINT, 1.0 - 0.5 * _POINT])
"""Gauss points of both halves of a step, in shares of it."""

WEIGHTS = np.full(4, 0.25)
"""Their weights, in shares of the step."""

_JUMP = 0.05
"""Change of light within half a step beyond which its instants are looked at one by one."""
_FINE, _COARSE = 4096, 64
"""Points of the midpoint rule in half a step, with a jump and without."""

Light = Callable[[Floats], Floats]
"""Times (n,) [s] -> visible fraction of the sun (n,)."""


def light_weights(light: Light, start: float, step: float, steps: int) -> Floats:
    """Weights (steps, 4) [s] of the Gauss points of every step.

    light : the exact one.  start : [s], of the first step.  step : [s].
    """
    half = 0.5 * step
    edges: Floats = start + half * np.arange(2.0 * steps + 1.0)
    seen = np.asarray(light(edges))
    weights = np.repeat(0.5 * half * seen[:-1, None], 2, axis=1)
    change = np.abs(np.diff(seen))
    for changing, points in (
        ((change > 0.0) & (change <= _JUMP), _COARSE),
        (change > _JUMP, _FINE),
    ):
        rows = np.flatnonzero(changing)
        if rows.size:
            first: Floats = edges[rows]
            weights[rows] = _resolved(light, first, half, points)
    return weights.reshape(steps, 4)


def _resolved(light: Light, first: Floats, half: float, points: int) -> Floats:
    """Weights (m, 2) [s] of half steps that begin at (m,) [s]."""
    shares = (np.arange(points) + 0.5) / points
    times: Floats = (first[:, None] + half * shares).ravel()
    seen = np.asarray(light(times)).reshape(-1, points)
    # The straight lines that are one at their own Gauss point and zero at the other.
    late = (shares - _POINT) / (1.0 - 2.0 * _POINT)
    basis = np.stack([1.0 - late, late], axis=1)
    return half / points * seen @ basis
