"""The attitude in which the panels earn most, near a reference attitude."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.panels import SolarPanels, collecting_area

_GRID = 20000
_KEPT = 24
"""Best points of the grid from which the search goes on."""
_FINEST = 1e-9
"""[rad], distance below which the search ends."""


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
    the unit sphere: kappa(s)^2 + k_1 cos(theta / 2), theta the angle of that turn.  A grid, then
    pattern search from its best points: the power has corners where a face comes into the light.

    irradiance : [W/m^2].  sun : (..., 3), direction of the sun in inertial axes.
    reference : (..., 4), q_ib.  path_weight : k_1 [W^2], greater than 0; a small one decides only
    between attitudes of equal power, such as rolls about the line to the sun.
    Source: Kristiansen (2023), eqs. (3.8) and (3.9).
    """
    sun, reference = _unit(np.asarray(sun, float)), np.asarray(reference, float)
    shape = np.broadcast_shapes(sun.shape[:-1], reference.shape[:-1])
    sun = np.broadcast_to(sun, (*shape, 3)).reshape(-1, 3)
    reference = np.broadcast_to(reference, (*shape, 4)).reshape(-1, 4)
    seen = np.asarray(quaternion.rotate_inverse(reference, sun))
    best = _best_directions(panels, irradiance, seen, path_weight)
    found = np.asarray(quaternion.multiply(reference, _shortest_turn(best, seen)))
    return found.reshape(*shape, 4)


def _best_directions(panels: SolarPanels, irradiance: float, seen: Floats, weight: float) -> Floats:
    """Direction (m, 3) of the sun in body axes that is best for each (m, 3) of the reference."""
    grid = _sphere(_GRID)
    power = np.asarray(_squared_power(panels, irradiance, grid))
    values = power[None] + weight * _nearness(grid[None], seen[:, None])
    kept = np.argpartition(-values, _KEPT, axis=1)[:, :_KEPT]
    at, value = grid[kept], np.take_along_axis(values, kept, axis=1)
    size = np.sqrt(4.0 * np.pi / _GRID)
    while size > _FINEST:
        trials = _unit(at[:, :, None] + size * _around(at))
        power = np.asarray(_squared_power(panels, irradiance, trials))
        found = power + weight * _nearness(trials, seen[:, None, None])
        choice = found.argmax(axis=2)[:, :, None]
        most = np.take_along_axis(found, choice, axis=2)[:, :, 0]
        better = most > value
        moved = np.take_along_axis(trials, choice[..., None], axis=2)[:, :, 0]
        at = np.where(better[..., None], moved, at)
        value = np.where(better, most, value)
        if not better.any():
            size *= 0.5
    winner = value.argmax(axis=1)
    chosen: Floats = at[np.arange(len(at)), winner]
    return chosen


@jax.jit
def _squared_power(panels: SolarPanels, irradiance: Array | float, sun_b: Array) -> Array:
    """kappa^2 (...) [W^2] for directions (..., 3) of the sun in body axes."""
    return jnp.square(irradiance * collecting_area(panels, sun_b))


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
    half_turn = np.concatenate([0.0 * cosine, _unit(np.cross(start, least))], axis=-1)
    q = np.where(cosine < -1.0 + 1e-12, half_turn, q)
    return _unit(q)


def _unit(v: Floats) -> Floats:
    unit: Floats = v / np.linalg.norm(v, axis=-1, keepdims=True)
    return unit


def _sphere(count: int) -> Floats:
    """Points (count, 3) spread evenly over the sphere, on a Fibonacci spiral."""
    k = np.arange(float(count)) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    points: Floats = np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=-1)
    return points


def _around(at: Floats) -> Floats:
    """Eight tangent unit vectors (..., 8, 3) around each of the points (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(at), axis=-1)]
    first = _unit(np.cross(at, least))
    second = np.cross(at, first)
    angles = 0.25 * np.pi * np.arange(8.0)[:, None]
    around: Floats = first[..., None, :] * np.cos(angles) + second[..., None, :] * np.sin(angles)
    return around
