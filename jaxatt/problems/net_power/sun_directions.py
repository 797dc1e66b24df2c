"""Directions in body axes from which the sun shines best on the panels, by search on the sphere."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass

import jax
import numpy as np
from jax import Array

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.panels import SolarPanels, collecting_area

_GRID = 20000
_FINEST = 1e-9
"""[rad], distance below which the search ends."""
_TRIED = 12
"""Maxima of the grid from which the search goes on."""
_TRIED_NEAR, _NEAR = 0.9, 0.995
"""Maxima are searched from this share of the grid's best, and count from that of the best."""
_APART = 0.3
"""[rad], between two maxima."""


@dataclass(frozen=True, eq=False)
class Directions:
    """Local maxima of the collecting area.

    body : (m, 3), unit vectors in body axes.  most : [m^2], of the best.
    """

    body: Floats
    most: float


@jax.jit
def area_seen(panels: SolarPanels, sun: Array | Floats) -> Array:
    """Collecting area (...) [m^2] for directions (..., 3) of the sun in body axes."""
    return collecting_area(panels, sun)


_known: dict[Hashable, Directions] = {}
"""Directions of panels that were asked for before: those of one vehicle serve all manoeuvres."""


def best_directions(panels: SolarPanels) -> Directions:
    """Find the best directions of the sun in body axes: all maxima nearly as good as the best."""
    leaves, tree = jax.tree.flatten(panels)
    key = (tree, *(np.asarray(leaf).tobytes() for leaf in leaves))
    if key not in _known:
        _known[key] = _searched(panels)
    return _known[key]


def _searched(panels: SolarPanels) -> Directions:
    grid = sphere()
    areas = np.asarray(area_seen(panels, grid))
    order = np.argsort(-areas, kind="stable")
    tried = _apart(grid[order[areas[order] >= _TRIED_NEAR * areas.max()]])[:_TRIED]
    # Of one shape, whatever the panels: what is evaluated compiles once.
    found, area = climbed(
        lambda sun: np.asarray(area_seen(panels, sun)), np.resize(tried, (_TRIED, 3))
    )
    # Equal ones in an order that rounding does not decide.
    share = area / area.max()
    order = np.argsort(-share.round(9), kind="stable")
    return Directions(np.array(_apart(found[order[share[order] >= _NEAR]])), float(area.max()))


def _apart(ordered: Floats) -> list[Floats]:
    """Those of unit vectors (n, 3) that stand apart from all before them."""
    kept: list[Floats] = []
    while len(ordered):
        kept.append(ordered[0])
        ordered = ordered[ordered @ ordered[0] < np.cos(_APART)]
    return kept


def climbed(value: Callable[[Floats], Floats], at: Floats) -> tuple[Floats, Floats]:
    """Climb to local maxima on the sphere: points (..., 3), and their values (...).

    A pattern search, because the area has corners where a face comes into the light.
    value : (..., 3) -> (...), for any leading axes.  at : (..., 3), points to begin from.
    """
    best, size = value(at), float(np.sqrt(4.0 * np.pi / _GRID))
    while size > _FINEST:
        trials = unit(at[..., None, :] + size * _around(at))
        found = value(trials)
        choice = found.argmax(axis=-1)[..., None]
        most = np.take_along_axis(found, choice, axis=-1)[..., 0]
        better = most > best
        moved = np.take_along_axis(trials, choice[..., None], axis=-2)[..., 0, :]
        at, best = np.where(better[..., None], moved, at), np.where(better, most, best)
        if not better.any():
            size *= 0.5
    return at, best


def unit(v: Floats) -> Floats:
    """Vectors (..., 3) over their lengths."""
    direction: Floats = v / np.linalg.norm(v, axis=-1, keepdims=True)
    return direction


def sphere(count: int = _GRID) -> Floats:
    """Points (count, 3) spread evenly over the sphere, on a Fibonacci spiral."""
    k = np.arange(float(count)) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    points: Floats = np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=-1)
    return points


def _around(at: Floats) -> Floats:
    """Eight tangent unit vectors (..., 8, 3) around each of the points (..., 3)."""
    least = np.eye(3)[np.argmin(np.abs(at), axis=-1)]
    first = unit(np.cross(at, least))
    second = np.cross(at, first)
    angles = 0.25 * np.pi * np.arange(8.0)[:, None]
    around: Floats = first[..., None, :] * np.cos(angles) + second[..., None, :] * np.sin(angles)
    return around
