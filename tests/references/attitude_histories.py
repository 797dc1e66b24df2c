"""Random turns for the tests of attitude files."""

from __future__ import annotations

import datetime as dt

import numpy as np
from scipy.spatial.transform import Rotation

from jaxatt.attitude.attitude_path import through
from jaxatt.exchange.motion import AttitudeHistory

EPOCH = dt.datetime(2026, 6, 21, 11, 59, 58, 250000, dt.UTC)


def turning(
    seed: int = 0, count: int = 40, step: float = 0.5, size: float = 0.3
) -> AttitudeHistory:
    """A smooth random turn; size : [rad], of its swings; of 0.3, some 0.05 rad/s."""
    drawn = np.random.default_rng(seed)
    time = step * np.arange(count)
    slow = [
        size * drawn.normal(size=3) * np.sin(rate * time[:, None] + drawn.uniform(0.0, 6.0, 3))
        for rate in (0.05, 0.11, 0.17)
    ]
    turn = Rotation.random(random_state=seed) * Rotation.from_rotvec(sum(slow))
    q = turn.as_quat(scalar_first=True)
    return AttitudeHistory(EPOCH, time, q, through(time, q).omega)


def scipy_turn(history: AttitudeHistory) -> Rotation:
    """Its attitudes as SciPy's rotations, from body to inertial axes."""
    return Rotation.from_quat(history.q_ib, scalar_first=True)
