"""What shows in attitudes and rates that a file was read, or written, in another convention."""

from __future__ import annotations

import numpy as np

from jaxatt.attitude.attitude_path import turn_between
from jaxatt.attitude.host_turns import conjugate
from jaxatt.exchange.moments import Instants, short
from jaxatt.exchange.motion import FileFormatError
from jaxatt.runtime.arrays import Floats

_NORM = 1e-3
"""Deviation of a quaternion's norm from 1 that rounding does not make."""
_FITS, _DIFFERS = 0.05, 0.3
"""Share of the rates by which those of the motion fit them, or do not."""
_STILL = 1e-7
"""[rad/s] below which rates tell nothing."""
_FAR = 0.5
"""[rad] between two attitudes beyond which their difference is no rate."""


def check_norms(q: Floats, moments: Instants, where: str) -> None:
    """Refuse rows that are no unit quaternions; q : (n, 4)."""
    norms = np.linalg.norm(q, axis=1)
    wrong = np.flatnonzero(~(np.abs(norms - 1.0) <= _NORM))
    if wrong.size:
        k = int(wrong[0])
        raise FileFormatError(
            where,
            f"the quaternion at {short(moments[k])} has norm {norms[k]:.6g}",
            "check that its four columns are those of a unit quaternion",
        )


def check_motion(time: Floats, p: Floats, rates: Floats, where: str) -> None:
    """Refuse attitudes that do not move as their rates say, and say which convention would fit.

    time : (n,) [s].  p : (n, 4), scalar first.  rates : (n, 3) [rad/s], in the axes turned to.
    Without motion nothing is told.
    """
    if len(p) < 2:
        return
    mean = 0.5 * (rates[:-1] + rates[1:])
    size = float(np.median(np.linalg.norm(mean, axis=1)))
    near = np.linalg.norm(turn_between(p), axis=1) < _FAR
    if size < _STILL or not near.any():
        return
    step = np.diff(time)[:, None]

    def off(q: Floats) -> float:
        apart = np.linalg.norm(turn_between(q) / step - mean, axis=1)[near]
        return float(np.median(apart)) / size

    if off(p) < _DIFFERS:
        return
    swapped = p[:, [1, 2, 3, 0]]  # numbers in the order of the file, if its first was the scalar
    other = p[:, [3, 0, 1, 2]]
    readings = {
        "the scalar at the other end": (swapped, other),
        "the turn in the opposite direction": (conjugate(p),),
        "the scalar at the other end and the turn in the opposite direction": (
            conjugate(swapped),
            conjugate(other),
        ),
    }
    fitting = [words for words, forms in readings.items() if min(map(off, forms)) < _FITS]
    raise FileFormatError(
        where,
        f"its attitudes do not move as its rates say (they differ by {100.0 * off(p):.0f} %)",
        f"they would with {fitting[0]}: correct the file or its keywords"
        if fitting
        else "check the frame and the unit of the rates, deg/s, and the order of the quaternion",
    )
