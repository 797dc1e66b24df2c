"""Paths between attitudes, in NumPy."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.net_power.pose import product
from jaxatt.runtime.arrays import Floats


def blend(begin: Floats, end: Floats, share: Floats) -> Floats:
    """Attitudes (n, 4) along the shorter turn between two, smooth at both of its ends.

    share : (n,), of the time of the turn; before 0 and after 1 it rests.
    """
    s = np.clip(share, 0.0, 1.0)
    s = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    turn = product(begin * np.array([1.0, -1.0, -1.0, -1.0]), end)
    turn = -turn if turn[0] < 0.0 else turn
    sine = float(np.linalg.norm(turn[1:]))
    half = np.arctan2(sine, turn[0])
    axis = turn[1:] / sine if sine > 1e-12 else np.zeros(3)
    return np.stack([product(begin, np.append(np.cos(a), np.sin(a) * axis)) for a in half * s])
