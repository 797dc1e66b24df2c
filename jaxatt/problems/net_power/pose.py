"""An attitude and the rate at which it turns, in plain NumPy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class Pose:
    """Attitude q_ib (4,), and the rate omega_ib (3,) [rad/s] in body axes with which it turns."""

    q_ib: Floats
    omega_ib: Floats

    def after(self, time: float) -> Pose:
        """The pose after turning at the constant rate for a time [s]."""
        half = 0.5 * time * self.omega_ib
        angle = float(np.linalg.norm(half))
        turn = np.concatenate([[math.cos(angle)], np.sinc(angle / np.pi) * half])
        return Pose(product(self.q_ib, turn), self.omega_ib)


def product(q: Floats, r: Floats) -> Floats:
    """Quaternion product (4,) in NumPy: exact whatever precision JAX is set to."""
    vector = q[0] * r[1:] + r[0] * q[1:] + np.cross(q[1:], r[1:])
    return np.concatenate([[q[0] * r[0] - q[1:] @ r[1:]], vector])


def angle_between(q: Floats, r: Floats) -> float:
    """Angle [rad] of the rotation between two attitudes (4,)."""
    difference = product(q * np.array([1.0, -1.0, -1.0, -1.0]), r)
    return 2.0 * math.atan2(float(np.linalg.norm(difference[1:])), abs(float(difference[0])))
