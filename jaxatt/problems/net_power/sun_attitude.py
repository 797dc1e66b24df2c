"""The attitude in which the panels earn most, near a reference attitude."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.problems.net_power.sun_directions import area_seen, climbed, sphere, unit
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.panels import SolarPanels

_KEPT = 24
"""Best points of the grid from which the search goes on."""


def sun_attitude(
    panels: SolarPanels,
    irradiance: float,
    sun: Any,
    reference: Any,
    path_weight: float = 1.0,
) -> Floats:
    """Attitude q_ib (..., 4) of most solar power, near a reference: the global optimum of (3.8).

    Of all attitudes in which the sun is seen in one direction of the body, the nearest to the
    reference is the shortest turn away.  So what is left of (3.8) is to choose that direction s on
    the unit sphere: kappa(s)^2 + k_1 cos(theta / 2), theta the angle of that turn.

    irradiance : [W/m^2].  sun : (..., 3), direction of the sun in inertial axes.
    reference : (..., 4), q_ib.  path_weight : k_1 [W^2], greater than 0; a small one decides only
    between attitudes of equal power, such as rolls about the line to the sun.
    Source: Kristiansen (2023), eqs. (3.8) and (3.9).
    """
    sun, reference = unit(np.asarray(sun, float)), np.asarray(reference, float)
    shape = np.broadcast_shapes(sun.shape[:-1], reference.shape[:-1])
    sun = np.broadcast_to(sun, (*shape, 3)).reshape(-1, 3)
    reference = np.broadcast_to(reference, (*shape, 4)).reshape(-1, 4)
    seen = np.asarray(quaternion.rotate_inverse(reference, sun))
    best = _best_directions(panels, irradiance, seen, path_weight)
    found = np.asarray(quaternion.multiply(reference, _shortest_turn(best, seen)))
    return found.reshape(*shape, 4)


def _best_directions(panels: SolarPanels, irradiance: float, seen: Floats, weight: float) -> Floats:
    """Direction (m, 3) of the sun in body axes that is best for each (m, 3) of the reference."""

    def value(sun: Floats) -> Floats:
        power = irradiance * np.asarray(area_seen(panels, sun))
        wanted = seen.reshape(len(seen), *(1,) * (sun.ndim - 2), 3)
        return power**2 + weight * _nearness(sun, wanted)

    grid = sphere()
    values = value(np.broadcast_to(grid, (1, *grid.shape)))
    kept = np.argpartition(-values, _KEPT, axis=1)[:, :_KEPT]
    found, best = climbed(value, grid[kept])
    chosen: Floats = found[np.arange(len(found)), best.argmax(axis=1)]
    return chosen


def _nearness(direction: Floats, seen: Floats) -> Floats:
    """cos(theta / 2), which is |q' q_ref| for the shortest turn between two unit vectors."""
    cosine = np.clip(np.sum(direction * seen, axis=-1), -1.0, 1.0)
    half: Floats = np.sqrt(0.5 * (1.0 + cosine))
    return half


def _shortest_turn(start: Floats, end: Floats) -> Floats:
    """Quaternion (..., 4) of the shortest rotation from one unit vector (..., 3) to another."""
    cosine = np.sum(start * end, axis=-1, keepdims=True)
    q = np.concatenate([1.0 + cosine, np.cross(start, end)], axis=-1)
    least = np.eye(3)[np.argmin(np.abs(start), axis=-1)]
    half_turn = np.concatenate([0.0 * cosine, unit(np.cross(start, least))], axis=-1)
    q = np.where(cosine < -1.0 + 1e-12, half_turn, q)
    return unit(q)
