"""A map of the world in equal degrees, and tracks on it."""

from __future__ import annotations

import functools
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from jaxatt.drawing.figure import tidy
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LAND, COAST = "#F2EFE6", "#9A9A9A"
_LONGITUDES, _LATITUDES = (5, 10, 20, 30, 60), (5, 10, 15, 30)
"""[deg], between lines of the graticule."""
_LINES = 7
_SHAPE = 2.0  # width over height
_ROOM = 20.0  # [deg], around what a part of the map has to show


class Part(NamedTuple):
    """Part of a map; its edges [deg]."""

    west: float
    east: float
    south: float
    north: float


WORLD = Part(-180.0, 180.0, -90.0, 90.0)


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


def world_map(axes: Axes, part: Part = WORLD) -> None:
    """Draw the land and a graticule; longitude and latitude in degrees."""
    from matplotlib.collections import PolyCollection

    axes.add_collection(
        PolyCollection(list(_land()), facecolors=LAND, edgecolors=COAST, linewidths=0.5, zorder=0.5)
    )
    axes.set_xlim(part.west, part.east)
    axes.set_ylim(part.south, part.north)
    axes.set_aspect("equal")
    longitudes = _graticule(part.west, part.east, _LONGITUDES)
    latitudes = _graticule(part.south, part.north, _LATITUDES)
    axes.set_xticks(longitudes, [_degrees(x, "WE") for x in longitudes])
    axes.set_yticks(latitudes, [_degrees(y, "SN") for y in latitudes])
    tidy(axes)


def part_around(longitude: Floats, latitude: Floats) -> Part:
    """Part of the map that shows all of some places (n,) [rad] each, with room around them.

    The whole map where that is half of it or more, or crosses the 180th meridian.
    """
    x, y = (np.degrees(longitude) + 180.0) % 360.0 - 180.0, np.degrees(latitude)
    wide = max(float(np.ptp(x)), _SHAPE * float(np.ptp(y))) + 2.0 * _ROOM
    if wide >= 180.0:
        return WORLD
    west = min(max(0.5 * float(x.min() + x.max() - wide), -180.0), 180.0 - wide)
    high = wide / _SHAPE
    south = min(max(0.5 * float(y.min() + y.max() - high), -90.0), 90.0 - high)
    return Part(west, west + wide, south, south + high)


def track(axes: Axes, longitude: Floats, latitude: Floats, **style: Any) -> None:
    """Draw a line over the ground, broken where it leaves the map; (n,) [rad] each."""
    x, y = np.degrees(longitude), np.degrees(latitude)
    x = (x + 180.0) % 360.0 - 180.0
    leaves = np.flatnonzero(np.abs(np.diff(x)) > 180.0) + 1
    axes.plot(np.insert(x, leaves, np.nan), np.insert(y, leaves, np.nan), **style)


def _graticule(first: float, last: float, spacings: tuple[int, ...]) -> list[int]:
    """Lines [deg] between two edges, the closest of those that are not too many."""
    spacing = next((s for s in spacings if last - first <= (_LINES - 1) * s), spacings[-1])
    lines = np.arange(np.ceil(first / spacing), np.floor(last / spacing) + 1) * spacing
    return [int(line) for line in lines]


def _degrees(value: int, letters: str) -> str:
    side = "" if value % 180 == 0 else letters[int(value > 0)]
    return f"{abs(value)}°{side}"
