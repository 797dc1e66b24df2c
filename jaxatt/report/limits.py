"""Largest torques that a set of wheels can give about the body axes."""

from __future__ import annotations

import itertools

import numpy as np

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.wheels import ReactionWheels

_MARGIN = 1e-9


def body_torque_limit(wheels: ReactionWheels, allocated: bool) -> Floats:
    """Largest torque (3,) [N m] about each body axis, whatever acts about the others.

    allocated : whether the Moore-Penrose allocation shares a body torque out to the wheels; it
    gives less than wheels that are commanded one by one.
    """
    limit = np.asarray(wheels.torque_limit, float)
    if not allocated:
        return np.asarray(np.abs(np.asarray(wheels.axes)) @ limit)
    shares = np.asarray(wheels.allocation) / limit[:, None]
    # The allowed body torques form a polytope; its extremes lie at corners, where three wheels
    # are at their limits.
    largest = np.zeros(3)
    for rows in itertools.combinations(shares, 3):
        if abs(np.linalg.det(np.stack(rows))) < _MARGIN * np.prod(np.linalg.norm(rows, axis=1)):
            continue
        for signs in itertools.product((-1.0, 1.0), repeat=3):
            corner = np.linalg.solve(np.stack(rows), np.asarray(signs))
            if np.abs(shares @ corner).max() <= 1.0 + _MARGIN:
                largest = np.maximum(largest, np.abs(corner))
    return largest
