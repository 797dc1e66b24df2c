"""Figure of a plan's ground track with its targets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.figure import picture
from jaxatt.drawing.world_map import part_around, track, world_map
from jaxatt.environment import ground
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.problems.net_power.plan.modes import COMMUNICATE, HARVEST, IDLE, IMAGE
from jaxatt.problems.net_power.plan.report.course import Course
from jaxatt.problems.net_power.plan.report.timeline import SHADOW
from jaxatt.problems.net_power.plan.sight import positions_over_ground
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from jaxatt.drawing.picture import Picture

COLOURS = {HARVEST: "#C9A227", IMAGE: "#009E73", COMMUNICATE: "#0072B2", IDLE: "#888888"}
"""Of the modes of operation, as lines."""

_STEP = 10.0  # [s], of the track
_ROOM = 0.025  # between two names, as a share of the map's height
_ASIDE = 0.025  # of a name from its place, as a share of the map's width


def ground_track(course: Course, flown: OrbitTask, title: str) -> Picture:
    """Draw where the satellite is above the ground during each task, and what it looks at.

    flown : the orbit, with its epoch.
    """
    figure = picture(11.0, 6.0, title)
    axes = figure.subplots()
    paths = [_below(flown, _instants(task)) for task in course.tasks]
    sites = [task.site for task in course.tasks if task.site is not None]
    seen = [np.array([[site.latitude], [site.longitude]]) for site in sites]
    latitude, longitude = np.concatenate([*map(np.stack, paths), *seen], axis=1)
    world_map(axes, part_around(longitude, latitude))
    for task, (latitude, longitude) in zip(course.tasks, paths, strict=True):
        dark = np.interp(_instants(task), course.time, course.light) < 0.5
        under = np.where(dark, latitude, np.nan)
        track(axes, longitude, under, color=SHADOW, alpha=0.35, linewidth=7.0, zorder=2)
        wide = 1.6 if task.mode == HARVEST else 3.2
        track(axes, longitude, latitude, color=COLOURS[task.mode], linewidth=wide, zorder=3)
        if task.site is None:
            continue
        place = np.degrees([task.site.longitude, task.site.latitude])
        axes.plot(*place, marker="x", color=COLOURS[task.mode], markersize=7, zorder=4)
    _names(axes, course.tasks)
    latitude, longitude = paths[0]
    axes.plot(
        *np.degrees([longitude[0], latitude[0]]), marker="o", color="black", markersize=5, zorder=5
    )
    figure.legend(
        handles=_legend(course), frameon=False, fontsize=8, loc="outside lower center", ncols=6
    )
    return figure


def _instants(task: Task) -> Floats:
    return np.linspace(task.start, task.end, max(2, round(task.duration / _STEP) + 1))


def _below(flown: OrbitTask, times: Floats) -> tuple[Floats, Floats]:
    latitude, longitude = ground.point_below(positions_over_ground(flown, times))
    return np.asarray(latitude), np.asarray(longitude)


def _names(axes: Axes, tasks: Sequence[Task]) -> None:
    """Write each place's name once, beside it, with room between the names of neighbours."""
    from matplotlib.patheffects import withStroke

    sites = {task.site: task.name for task in reversed(tasks) if task.site is not None}
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    room, aside, above = _ROOM * (north - south), _ASIDE * (east - west), np.inf
    for site in sorted(sites, key=lambda site: -site.latitude):
        place = (float(np.degrees(site.longitude)), float(np.degrees(site.latitude)))
        above = min(place[1] - 0.25 * room, above - room)
        axes.annotate(
            sites[site],
            place,
            xytext=(place[0] + aside, above),
            fontsize=8,
            va="center",
            zorder=6,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
            arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.5},
        )


def _legend(course: Course) -> list[Line2D]:
    from matplotlib.lines import Line2D

    modes = dict.fromkeys(task.mode for task in course.tasks)
    handles = [Line2D([], [], color=COLOURS[mode], linewidth=2.5, label=mode) for mode in modes]
    if (course.light < 0.5).any():
        handles.append(Line2D([], [], color=SHADOW, alpha=0.35, linewidth=7.0, label="eclipse"))
    handles.append(Line2D([], [], color="black", marker="o", linestyle="", label="start"))
    return handles
