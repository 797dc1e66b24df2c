"""Cones that are always satisfied, so that slews past one to four cones share compiled programs.

Compiling the search past cones takes far longer than solving past three cones too many.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jaxatt.problems.pointing.cones import KEEP_IN, PointingPath

_APART = 4
"""Numbers of cones that programs are compiled for are multiples of this."""


def spare_cones(count: int) -> int:
    """How many cones are added to so many."""
    return -count % _APART


def with_spare_cones(path: PointingPath, more: int) -> PointingPath:
    """The same limits, and more cones about no direction: their margins are positive, and fixed."""
    if not more:
        return path
    limits = path.limits

    def filled(leaf: Any, value: float, axis: int) -> Any:
        leaf = np.asarray(leaf)
        widths = [(0, more if k == axis else 0) for k in range(leaf.ndim)]
        return np.pad(leaf, widths, constant_values=value)

    return replace(
        path,
        limits=replace(
            limits,
            boresights=filled(limits.boresights, 0.0, 0),
            cosines=filled(limits.cosines, -0.5, 0),
            senses=filled(limits.senses, KEEP_IN, 0),
        ),
        directions=filled(path.directions, 0.0, 1),
    )
