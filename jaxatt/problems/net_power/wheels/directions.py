"""Directions from which the sun shines best on the panels."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.attitude.components import Vector
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.panels import SolarPanels, collecting_area

_SPREAD = 4096
_ROUNDS = 8
_NEAR = 0.995
"""Local maxima count from this share of the best."""
_APART = 0.3


@dataclass(frozen=True, eq=False)
class Directions:
    """Local maxima of the collecting area.

    body : (m, 3), unit vectors in body axes.  most : [m^2], of the best.
    """

    body: Floats
    most: float


def best_directions(panels: SolarPanels) -> Directions:
    """Find the best directions of the sun in body axes: all maxima nearly as good as the best.

    Directions spread evenly over the sphere, then ever finer ones around the best of them; the area
    may have corners, which rules out slopes.
    """
    areas = _areas(panels, _sphere(_SPREAD))
    sphere = _sphere(_SPREAD)
    order = np.argsort(-areas)
    found: list[Floats] = []
    for index in order[: _SPREAD // 8]:
        if areas[index] < 0.9 * areas[order[0]]:
            break
        if all(sphere[index] @ other < np.cos(_APART) for other in found):
            found.append(sphere[index])
    rng = np.random.default_rng(0)
    refined = [_refined(panels, direction, rng) for direction in found[:12]]
    best = np.array([area for _, area in refined])
    kept: list[Floats] = []
    for index in np.argsort(-best):
        direction = refined[index][0]
        apart = all(direction @ other < np.cos(_APART) for other in kept)
        if best[index] >= _NEAR * best.max() and apart:
            kept.append(direction)
    return Directions(np.array(kept), float(best.max()))


def _refined(
    panels: SolarPanels, direction: Floats, rng: np.random.Generator
) -> tuple[Floats, float]:
    spread, best = 0.05, 0.0
    for _ in range(_ROUNDS):
        around = direction + spread * rng.standard_normal((255, 3))
        around = np.concatenate([direction[None], around])
        around /= np.linalg.norm(around, axis=1, keepdims=True)
        areas = _areas(panels, np.resize(around, (_SPREAD, 3)))[:256]
        direction, best = around[areas.argmax()], float(areas.max())
        spread *= 0.3
    return direction, best


def _sphere(count: int) -> Floats:
    """Nearly even directions by a spiral, (count, 3)."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


@jax.jit
def _area(panels: SolarPanels, sun: jax.Array) -> jax.Array:
    return collecting_area(panels, Vector.of(sun))


def _areas(panels: SolarPanels, directions: Floats) -> Floats:
    return np.asarray(_area(jax.tree.map(jnp.asarray, panels), directions))
