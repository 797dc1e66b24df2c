"""Shortest time of a rest-to-rest turn about a fixed axis, for comparison."""

from __future__ import annotations

import itertools
import math

import numpy as np

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.vehicle import Spacecraft

_PARALLEL = 1e-9


def eigenaxis_time(craft: Spacecraft, axis: Floats, angle: float) -> float:
    """Shortest time [s] of a rest-to-rest turn about a fixed axis, with full torque on and back.

    craft : its wheels, if any, at rest at the start, so that no momentum turns with the body.
    axis : (3,), unit vector in body axes.  angle : [rad].

    Without wheels the axis must be a principal one, or the gyroscopic torque, which is left out,
    would have to be held against; see `has_no_gyroscopic_torque`.
    """
    wanted = np.asarray(craft.inertia_without_spin) @ axis
    slowness = 1.0 / acceleration(craft, wanted) + 1.0 / acceleration(craft, -wanted)
    return math.sqrt(2.0 * angle * slowness)


def acceleration(craft: Spacecraft, direction: Floats) -> float:
    """Largest a such that all actuators together can give the torque a times `direction`, (3,).

    The torques that they can give form a zonotope, whose faces are parallel to two of them each.
    """
    wheels, thrusters = craft.wheels, craft.thrusters
    most = np.asarray(wheels.torque_limit)
    columns = np.concatenate([wheels.axes, thrusters.distribution], axis=1)
    lower = np.concatenate([-most, np.zeros(thrusters.count)])
    upper = np.concatenate([most, thrusters.torque_limit])
    found = math.inf
    for first, second in itertools.combinations(columns.T, 2):
        normal = np.cross(first, second)
        along = float(normal @ direction)
        if abs(along) <= _PARALLEL * np.linalg.norm(normal) * np.linalg.norm(direction):
            continue
        pushes = math.copysign(1.0, along) * (normal @ columns)
        reach = float(np.maximum(pushes * lower, pushes * upper).sum())
        found = min(found, reach / abs(along))
    return found


def has_no_gyroscopic_torque(craft: Spacecraft, axis: Floats) -> bool:
    """Whether a turn about this axis from rest needs no torque across it."""
    spun = np.asarray(craft.inertia) @ axis
    principal = np.linalg.norm(np.cross(axis, spun)) <= 1e-9 * np.linalg.norm(spun)
    return bool(principal) or craft.thrusters.count == 0
