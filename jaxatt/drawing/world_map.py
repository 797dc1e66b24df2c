"""A map of the world in equal degrees, and tracks on it."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from jaxatt.drawing.figure import tidy
from jaxatt.runtime.arrays import Floats

LAND, COAST = "#F2EFE6", "#9A9A9A"


@functools.cache
def _land() -> tuple[Floats, ...]:
    """Outlines of the land, each (n, 2): longitude and latitude [deg].

    Those that cross the 180th meridian go on beyond it, and come a second time from the other side;
    the one round the pole is closed along the map's lower edge.
    """
    path = resources.files("jaxatt.drawing") / "data" / "land.txt"
    rows = path.read_text(encoding="ascii").splitlines()
    outlines: list[Floats] = []
    for row in rows:
        outline = np.array([[float(part) for part in point.split(",")] for point in row.split()])
        outline[:, 0] = np.unwrap(outline[:, 0], period=360.0)
        first, last = outline[0], outline[-1]
        if abs(last[0] - first[0]) > 180.0:
            outline = np.vstack([outline, [last[0], -90.0], [first[0], -90.0]])
        outlines.append(outline)
        for turn in (-360.0, 360.0):
            moved = outline + np.array([turn, 0.0])
            if moved[:, 0].max() > -180.0 and moved[:, 0].min() < 180.0:
                outlines.append(moved)
    return tuple(outlines)


def world_map(axes: Axes) -> None:
    """Draw the land and a graticule; longitude and latitude in degrees."""
    axes.add_collection(
        PolyCollection(list(_land()), facecolors=LAND, edgecolors=COAST, linewidths=0.5, zorder=0.5)
    )
    axes.set_xlim(-180.0, 180.0)
    axes.set_ylim(-90.0, 90.0)
    axes.set_aspect("equal")
    axes.set_xticks(np.arange(-180, 181, 60), [_degrees(x, "WE") for x in range(-180, 181, 60)])
    axes.set_yticks(np.arange(-90, 91, 30), [_degrees(y, "SN") for y in range(-90, 91, 30)])
    tidy(axes)


def track(axes: Axes, longitude: Floats, latitude: Floats, **style: Any) -> None:
    """Draw a line over the ground, broken where it leaves the map; (n,) [rad] each."""
    x, y = np.degrees(longitude), np.degrees(latitude)
    x = (x + 180.0) % 360.0 - 180.0
    leaves = np.flatnonzero(np.abs(np.diff(x)) > 180.0) + 1
    axes.plot(np.insert(x, leaves, np.nan), np.insert(y, leaves, np.nan), **style)


def _degrees(value: int, letters: str) -> str:
    side = "" if value % 180 == 0 else letters[int(value > 0)]
    return f"{abs(value)}°{side}"
