"""What shows in attitudes and rates that a file was read, or written, in another convention."""

from __future__ import annotations

import math

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
_ENOUGH, _FAR = 0.02, 0.5
"""[rad] between two attitudes that are compared: enough to tell, and about one axis still."""


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
    step = np.diff(time)[:, None]
    turned = np.concatenate([np.zeros((1, 3)), np.cumsum(0.5 * step * (rates[:-1] + rates[1:]), 0)])
    way = float(np.linalg.norm(np.diff(turned, axis=0), axis=1).sum())
    # Compared over so many steps that rounded quaternions still tell.
    each = max(1, math.ceil(_ENOUGH * (len(time) - 1) / way)) if way > _ENOUGH else len(time)
    told = turned[each:] - turned[:-each]
    length = np.linalg.norm(told, axis=1)
    near = np.linalg.norm(turn_between(np.stack([p[each:], p[:-each]]))[0], axis=1) < _FAR
    pairs = np.flatnonzero((length > 0.5 * _ENOUGH) & near)
    if not pairs.size:
        return

    def off(q: Floats) -> float:
        moved = turn_between(np.stack([q[pairs], q[pairs + each]]))[0]
        return float(np.median(np.linalg.norm(moved - told[pairs], axis=1) / length[pairs]))

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
