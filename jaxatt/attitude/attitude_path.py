"""A smooth turn through attitudes that are given at instants, on the host.

Between two instants the rotation vector from the first of them is the cubic polynomial that has the
given attitudes and rates at both: attitude and rate are continuous, and where the torque is held in
between the attitude is wrong by the fourth power of the interval only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.attitude.host_turns import conjugate, product, turn_of, turned_by
from jaxatt.runtime.arrays import Floats

_SMALL = 1e-4
"""[rad] below which the factors of a rotation vector's rate are their series."""


@dataclass(frozen=True, eq=False)
class AttitudePath:
    """Attitudes and rates at n instants, and between them.

    time : (n,) [s], increasing.  q : (n, 4), unit quaternions; their signs do not matter.
    omega : (n, 3) [rad/s], rates in body axes.
    """

    time: Floats
    q: Floats
    omega: Floats

    def at(self, time: Floats) -> tuple[Floats, Floats]:
        """Attitudes (m, 4) and rates (m, 3) [rad/s] at times (m,) [s] between first and last."""
        k = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        step = self.time[k + 1] - self.time[k]
        x = ((time - self.time[k]) / step)[:, None]
        turn = _short_way(self.q[k], self.q[k + 1])
        first = step[:, None] * self.omega[k]
        last = step[:, None] * _vector_rate(turn, self.omega[k + 1])
        vector = (
            x * (1.0 - x) ** 2 * first + x**2 * (3.0 - 2.0 * x) * turn + x**2 * (x - 1.0) * last
        )
        slope = (
            (1.0 - x) * (1.0 - 3.0 * x) * first
            + 6.0 * x * (1.0 - x) * turn
            + x * (3.0 * x - 2.0) * last
        )
        return product(self.q[k], turned_by(vector)), _body_rate(vector, slope / step[:, None])


def through(time: Floats, q: Floats) -> AttitudePath:
    """Path through attitudes without known rates, which are taken from a smooth spline.

    time : (n,) [s], n of at least 2.  q : (n, 4).
    """
    from scipy.spatial.transform import Rotation, RotationSpline

    spline = RotationSpline(time, Rotation.from_quat(q, scalar_first=True))
    return AttitudePath(time, q, np.asarray(spline(time, 1)))


def turn_between(q: Floats) -> Floats:
    """Rotation vectors (n - 1, 3) [rad] from each attitude (n, 4) to the next, the short way."""
    return _short_way(q[:-1], q[1:])


def _short_way(a: Floats, b: Floats) -> Floats:
    relative = product(conjugate(a), b)
    return turn_of(np.where(relative[..., :1] < 0.0, -relative, relative))


def _body_rate(vector: Floats, slope: Floats) -> Floats:
    """Rate in body axes of a rotation vector (..., 3) that changes by `slope` a second."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    small = angle < _SMALL
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    b = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    across = np.cross(vector, slope)
    return np.asarray(slope - a * across + b * np.cross(vector, across))


def _vector_rate(vector: Floats, omega: Floats) -> Floats:
    """Change a second of a rotation vector (..., 3) at a rate in body axes."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    small = angle < _SMALL
    half = 0.5 * np.where(small, 1.0, angle)
    c = np.where(
        small, 1.0 / 12.0 + angle**2 / 720.0, (1.0 - half / np.tan(half)) / (2.0 * half) ** 2
    )
    across = np.cross(vector, omega)
    return np.asarray(omega + 0.5 * across + c * np.cross(vector, across))
