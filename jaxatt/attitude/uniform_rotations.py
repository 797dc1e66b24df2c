"""Rotations spread evenly over all of SO(3).

Source: Alexa (2022), "Super-Fibonacci spirals: fast, low-discrepancy sampling of SO(3)".
"""

from __future__ import annotations

import numpy as np

from jaxatt.runtime.arrays import Floats

_PHI = np.sqrt(2.0)
_PSI = 1.533751168755204288118041
"""The root of psi^4 = psi + 4 that the source finds to spread points best with phi = sqrt(2)."""


def uniform_rotations(count: int) -> Floats:
    """Unit quaternions (count, 4), scalar first and not negative; the same for the same count."""
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2.0 * np.pi * s / _PHI, 2.0 * np.pi * s / _PSI
    parts = inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta), outer * np.cos(beta)
    q = np.stack(parts, axis=-1)
    return np.asarray(np.where(q[:, :1] < 0.0, -q, q))
