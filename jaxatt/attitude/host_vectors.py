"""Vectors of many starts at once on the host, in NumPy."""

from __future__ import annotations

import numpy as np

from jaxatt.runtime.arrays import Floats


def cross(a: Floats, b: Floats) -> Floats:
    """Cross product (..., 3), several times faster than NumPy's for few vectors."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)
