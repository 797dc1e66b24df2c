"""Interpolation of positions and velocities between the states of a file."""

from __future__ import annotations

import numpy as np

from jaxatt.runtime.arrays import Floats

_NEAREST = 6
"""States whose positions and velocities one polynomial passes through: degree 11."""


class Hermite:
    """Polynomials through the nearest states on both sides.

    With states up to half a radian of the orbit apart, 8 min in a low one, the polynomial itself
    misses by less than a millimetre.  The velocities must be the derivatives of the positions;
    those of SGP4 are so to 2 cm/s only, which comes to centimetres between states a minute apart.

    times : (n,) [s], rising.  r : (n, 3) [m].  v : (n, 3) [m/s].
    """

    def __init__(self, times: Floats, r: Floats, v: Floats):
        self.times, self.r, self.v = times, r, v
        self.nodes = min(_NEAREST, len(times))

    def __call__(self, times: Floats) -> tuple[Floats, Floats]:
        """Positions (m, 3) [m] and velocities (m, 3) [m/s] at times (m,) [s] within the states."""
        after = np.searchsorted(self.times, times, side="right")
        first = np.clip(after - self.nodes // 2, 0, len(self.times) - self.nodes)
        windows, which = np.unique(first, return_inverse=True)
        rows = windows[:, None] + np.arange(self.nodes)
        middle = 0.5 * (self.times[rows[:, 0]] + self.times[rows[:, -1]])
        scale = 0.5 * (self.times[rows[:, -1]] - self.times[rows[:, 0]])
        powers = np.arange(2.0 * self.nodes)
        values, slopes = _basis((self.times[rows] - middle[:, None]) / scale[:, None], powers)
        given = np.concatenate([self.r[rows], scale[:, None, None] * self.v[rows]], axis=1)
        coefficients = np.linalg.solve(np.concatenate([values, slopes], axis=1), given)
        own = (times - middle[which]) / scale[which]
        value, slope = _basis(own, powers)
        r = np.einsum("mk,mkc->mc", value, coefficients[which])
        v = np.einsum("mk,mkc->mc", slope, coefficients[which]) / scale[which, None]
        return r, v


def _basis(x: Floats, powers: Floats) -> tuple[Floats, Floats]:
    """Powers (..., k) of x (...), and their derivatives."""
    values = x[..., None] ** powers
    slopes = np.zeros_like(values)
    slopes[..., 1:] = powers[1:] * values[..., :-1]
    return values, slopes
