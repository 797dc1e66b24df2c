"""Runge-Kutta steps an interval that keep the error of a turning body within a tolerance.

A body with momentum nutates however slowly it turns, at about |H| / J: the error of a step follows
from that, not from the torque.  So it is measured, on motions without torque: each is integrated
with some steps an interval and with twice as many, and the difference sets the number by the order
of the method.  On the host, because the number of steps is compiled in.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from jaxatt.runtime.arrays import Floats

States = tuple[Floats, Floats]
"""Attitudes (..., 4) and rates (..., 3) [rad/s]."""

_MEASURED = 20
"""Intervals that are integrated; over more of them errors are taken to add up alike."""
_MOST = 128
_ORDER = 4
_ROUNDS = 8
_ATTITUDE, _RATE, _MOMENTUM = range(4), range(4, 7), range(7, 10)


def steps_needed(
    inertia_without_spin: Floats,
    rate: Floats,
    momentum: Floats,
    step: float,
    intervals: int,
    tolerance: tuple[float, float],
) -> int:
    """Number of steps an interval, 128 at most, for motions without torque.

    inertia_without_spin : (3, 3) [kg m^2].  rate : (S, 3) [rad/s] and momentum : (S, 3) [N m s],
    total, at the start of each motion in body axes.  step : [s], an interval.
    tolerance : errors of attitude [rad] and rate [rad/s] that are allowed after all intervals.
    """
    inverse = np.asarray(np.linalg.inv(inertia_without_spin), float)
    count = min(intervals, _MEASURED)
    begin = np.concatenate([np.tile([1.0, 0.0, 0.0, 0.0], (len(rate), 1)), rate, momentum], axis=1)
    steps = 1
    coarse = _ended(begin, inverse, step, count, steps)
    for _ in range(_ROUNDS):
        fine = _ended(begin, inverse, step, count, 2 * steps)
        off = _apart(coarse, fine, tolerance) * intervals / count
        if off <= 1.0:
            return steps
        # What is not a number has overflowed, and says no more than that.
        more = 2.0 if not math.isfinite(off) else min(2.0, 1.05 * off ** (1.0 / _ORDER))
        steps = min(_MOST, max(steps + 1, math.ceil(steps * more)))
        if steps == _MOST:
            break
        coarse = _ended(begin, inverse, step, count, steps)
    return steps


def _slopes(inverse: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Floats]:
    """Torque-free motion as a quadratic form: i, j and c with dy/dt = (y[i] * y[j]) @ c.

    y : attitude (4), rate (3), momentum in body axes (3).  c : (18, 10).
    """
    turned, unit = np.concatenate([inverse, np.eye(3)], axis=1), np.eye(10)
    terms: list[tuple[int, int, Floats]] = []
    for k in range(3):
        along, into = _ATTITUDE[1 + k], np.concatenate([np.zeros(4), turned[k]])
        terms.append((_ATTITUDE[0], _RATE[k], 0.5 * unit[along]))
        terms.append((along, _RATE[k], -0.5 * unit[_ATTITUDE[0]]))
        # Component k of a cross product: a_i b_j - a_j b_i.
        for i, j, sign in ((k - 2, k - 1, 1.0), (k - 1, k - 2, -1.0)):
            terms.append((_ATTITUDE[1:][i], _RATE[j], 0.5 * sign * unit[along]))
            terms.append((_MOMENTUM[i], _RATE[j], sign * into))
    first, second, factors = zip(*terms, strict=True)
    return np.array(first), np.array(second), np.array(factors)


def _ended(y: Floats, inverse: Floats, step: float, intervals: int, steps: int) -> Floats:
    """States (S, 10) after all intervals: attitude (4), rate (3), momentum in body axes (3)."""
    h = step / steps
    # Few calls on small arrays, each of which costs more than its arithmetic.
    first, second, factors = _slopes(inverse)

    def slope(y: Floats) -> Floats:
        return np.asarray((y.take(first, 1) * y.take(second, 1)) @ factors)

    with np.errstate(all="ignore"):
        for _ in range(intervals * steps):
            a = slope(y)
            b = slope(y + 0.5 * h * a)
            c = slope(y + 0.5 * h * b)
            y = y + h / 6.0 * (a + 2.0 * (b + c) + slope(y + h * c))
            y[:, :4] /= np.sqrt((y[:, :4] ** 2).sum(1, keepdims=True))
    return y


def states_apart(a: States, b: States) -> tuple[float, float]:
    """Largest angle [rad] and difference of rates [rad/s] between states.

    Infinite where one is not a number, as too few steps may leave it.
    """
    angle, rate = each_apart(a, b)
    return float(angle.max()), float(rate.max())


def each_apart(a: States, b: States) -> tuple[Floats, Floats]:
    """As `states_apart`, of every state."""
    with np.errstate(all="ignore"):
        same = np.where(np.sum(a[0] * b[0], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
        chord = np.linalg.norm(a[0] - same * b[0], axis=-1)
        angle = 4.0 * np.arcsin(np.minimum(1.0, 0.5 * chord))
        rate = np.linalg.norm(a[1] - b[1], axis=-1)
    return np.nan_to_num(angle, nan=np.inf), np.nan_to_num(rate, nan=np.inf)


def _apart(a: Floats, b: Floats, tolerance: tuple[float, float]) -> float:
    """Largest difference between states (S, 10), in units of the tolerances."""
    parts = ((y[:, :4], y[:, 4:7]) for y in (a, b))
    angle, rate = states_apart(*parts)
    return max(angle / tolerance[0], rate / tolerance[1])
