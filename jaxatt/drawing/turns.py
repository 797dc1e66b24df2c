"""Values over all turns: maps of the sphere of turn axes, one for each range of angles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, Normalize

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.runtime.arrays import Flags, Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture

_EDGES = (0.0, 60.0, 90.0, 120.0, 150.0, 180.0)
"""[deg], of the ranges of angles."""
_MOST_COLOURS = 12
_BINS = 18


def turns_figure(
    axis: Floats, angle: Floats, values: Floats, reached: Flags, name: str, title: str
) -> Picture:
    """Draw a value over turns.

    axis : (M, 3), unit vectors.  angle : (M,) [rad].  values : (M,).  reached : (M,), others are
    marked in grey.  name : of the value with its unit.
    """
    made = picture(11.0, 6.4, title)
    grid = made.add_gridspec(2, 3)
    degrees, shown = np.degrees(angle), reached & np.isfinite(values)
    norm = _norm(values[shown])
    places = [(row, column) for row in range(2) for column in range(3)]
    maps: list[Axes] = []
    for place, low, high in zip(places, _EDGES[:-1], _EDGES[1:], strict=False):
        axes = made.add_subplot(grid[place], projection="mollweide")
        here = (degrees > low) & (degrees <= high)
        _sphere(axes, axis[here], values[here], shown[here], norm)
        axes.set_title(f"turns of {low:g} to {high:g} deg", fontsize="medium")
        maps.append(axes)
    _over_angle(made.add_subplot(grid[places[-1]]), degrees, values, shown, name)
    cells = colormaps["viridis"]
    scale: Any = made.colorbar(
        _mappable(norm, cells), ax=maps, location="bottom", shrink=0.5, aspect=40
    )
    scale.set_label(name)
    return made


def _norm(values: Floats) -> Normalize:
    """Scale of colours: steps for whole numbers that are few."""
    if not len(values):
        return Normalize(0.0, 1.0)
    low, high = float(values.min()), float(values.max())
    if np.all(values == np.round(values)) and high - low < _MOST_COLOURS:
        return BoundaryNorm(np.arange(low - 0.5, high + 1.0), colormaps["viridis"].N)
    return Normalize(low, high)


def _mappable(norm: Normalize, cells: Any) -> Any:
    from matplotlib.cm import ScalarMappable

    return ScalarMappable(norm, cells)


def _sphere(axes: Axes, axis: Floats, values: Floats, shown: Flags, norm: Normalize) -> None:
    """Turn axes in body axes: x in the middle, z at the top."""
    longitude, latitude = np.arctan2(axis[:, 1], axis[:, 0]), np.arcsin(np.clip(axis[:, 2], -1, 1))
    size = float(np.clip(9000.0 / max(1, len(axis)), 3.0, 60.0))
    axes.scatter(longitude[~shown], latitude[~shown], s=size, marker="x", color="#BBBBBB", lw=0.6)
    axes.scatter(longitude[shown], latitude[shown], s=size, c=values[shown], norm=norm, lw=0)
    axes.set_xticks(np.radians([-90.0, 0.0, 90.0]), ["-y", "x", "y"])
    axes.set_yticks(np.radians([-45.0, 0.0, 45.0]), [])
    axes.grid(True, color="#CCCCCC", linewidth=0.5)


def _over_angle(axes: Axes, degrees: Floats, values: Floats, shown: Flags, name: str) -> None:
    axes.plot(degrees[shown], values[shown], ".", color=colour(5), ms=2, alpha=0.4)
    edges = np.linspace(0.0, 180.0, _BINS + 1)
    which = np.digitize(degrees, edges) - 1
    middles, medians = [], []
    for k in range(_BINS):
        here = shown & (which == k)
        if here.any():
            middles.append(0.5 * (edges[k] + edges[k + 1]))
            medians.append(float(np.median(values[here])))
    axes.plot(middles, medians, "-", color=colour(0), label="median")
    if (~shown).any():
        lost = degrees[~shown]
        axes.plot(
            lost,
            np.full(len(lost), 0.02),
            "x",
            color="#999999",
            ms=4,
            transform=axes.get_xaxis_transform(),
            label="not reached",
        )
    axes.set_xlim(0.0, 180.0)
    axes.set_xlabel("angle of the turn [deg]")
    axes.set_ylabel(name)
    axes.legend(frameon=False, fontsize=8)
    tidy(axes)
