"""The attitude in which the panels earn most, nearest to a reference attitude."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.panels import SolarPanels, collecting_area

_GRID = 20000
_KEPT = 64
"""Best points of the grid from which the search goes on."""
_SAME = 1e-9
"""Relative difference of areas that counts as none."""
_APART = 1e-3
"""[rad], distance from which two directions count as different ones."""

_areas = jax.jit(collecting_area)


def best_sun_directions(panels: SolarPanels) -> Floats:
    """Directions (k, 3) of the sun in body axes that give the panels the most power.

    All that are equally good: two where opposite faces are equal.  A flat maximum, as between two
    equal faces at a right angle under the law of squared cosines, gives some of its points.

    A grid over the sphere, then pattern search from its best points: that needs no derivative, and
    the power has corners where a face comes into the light.
    """
    points = _sphere(_GRID)
    values = np.asarray(_areas(panels, points))
    order = np.argsort(-values)[:_KEPT]
    at, size = points[order], np.sqrt(4.0 * np.pi / _GRID)
    value = values[order]
    while size > 1e-10:
        trials = _unit(at[:, None] + size * _around(at))
        found = np.asarray(_areas(panels, trials))
        best = found.argmax(axis=1)
        rows = np.arange(len(at))
        better = found[rows, best] > value
        at = np.where(better[:, None], trials[rows, best], at)
        value = np.where(better, found[rows, best], value)
        if not better.any():
            size *= 0.5
    kept: list[Floats] = []
    for k in np.argsort(-value, kind="stable"):
        new = all(np.linalg.norm(at[k] - other) > _APART for other in kept)
        if value[k] >= value.max() * (1.0 - _SAME) and new:
            kept.append(at[k])
    return np.array(kept)


def sun_attitude(panels: SolarPanels, sun: Any, reference: Any) -> Floats:
    """Attitude q_ib (..., 4) in which the panels earn most, nearest to a reference.

    The problem (3.8) for a weight k_1 so small that it only decides between attitudes that are
    equally good: the roll about the line to the sun, and which face looks there.

    sun : (..., 3), direction of the sun in inertial axes.  reference : (..., 4), q_ib.
    Source: Kristiansen (2023), eqs. (3.8) and (3.9).
    """
    directions = best_sun_directions(panels)
    sun, reference = _unit(np.asarray(sun, float)), np.asarray(reference, float)
    shape = np.broadcast_shapes(sun.shape[:-1], reference.shape[:-1])
    sun = np.broadcast_to(sun, (*shape, 3))
    reference = np.broadcast_to(reference, (*shape, 4))
    seen = np.asarray(quaternion.rotate_inverse(reference, sun))
    nearest = directions[np.argmax(seen @ directions.T, axis=-1)]
    turn = _shortest_turn(nearest, seen)
    return np.asarray(quaternion.multiply(reference, turn))


def _shortest_turn(start: Floats, end: Floats) -> Floats:
    """Quaternion (..., 4) of the shortest rotation from one unit vector (..., 3) to another."""
    cosine = np.sum(start * end, axis=-1, keepdims=True)
    q = np.concatenate([1.0 + cosine, np.cross(start, end)], axis=-1)
    least = np.eye(3)[np.argmin(np.abs(start), axis=-1)]
    half_turn = np.concatenate([0.0 * cosine, _unit(np.cross(start, least))], axis=-1)
    q = np.where(cosine < -1.0 + 1e-12, half_turn, q)
    unit: Floats = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return unit


def _unit(v: Floats) -> Floats:
    unit: Floats = v / np.linalg.norm(v, axis=-1, keepdims=True)
    return unit


def _sphere(count: int) -> Floats:
    """Points (count, 3) spread evenly over the sphere, on a Fibonacci spiral."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=-1)


def _around(at: Floats) -> Floats:
    """Eight tangent vectors (m, 8, 3) around each of the points (m, 3)."""
    least = np.eye(3)[np.argmin(np.abs(at), axis=-1)]
    first = _unit(np.cross(at, least))
    second = np.cross(at, first)
    angles = 2.0 * np.pi / 8.0 * np.arange(8)
    return first[:, None] * np.cos(angles)[:, None] + second[:, None] * np.sin(angles)[:, None]
