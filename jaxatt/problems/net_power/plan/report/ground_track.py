"""Figure of a plan's ground track with its targets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from jaxatt.drawing.figure import Picture, picture
from jaxatt.drawing.world_map import track, world_map
from jaxatt.environment import ground
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.problems.net_power.plan.report.course import Course
from jaxatt.problems.net_power.plan.report.timeline import SHADOW
from jaxatt.problems.net_power.plan.sight import positions_over_ground
from jaxatt.problems.net_power.plan.task import (
    COMMUNICATE,
    HARVEST,
    IDLE,
    IMAGE,
    Task,
)
from jaxatt.runtime.arrays import Floats

COLOURS = {HARVEST: "#C9A227", IMAGE: "#009E73", COMMUNICATE: "#0072B2", IDLE: "#888888"}
"""Of the modes of operation, as lines."""

_STEP = 10.0  # [s], of the track
_ROOM = 4.5  # [deg], between two names


def ground_track(course: Course, flown: OrbitTask, title: str) -> Picture:
    """Draw where the satellite is above the ground during each task, and what it looks at.

    flown : the orbit, with its epoch.
    """
    figure = picture(11.0, 6.0, title)
    axes = figure.subplots()
    world_map(axes)
    for task in course.tasks:
        times = _instants(task)
        latitude, longitude = _below(flown, times)
        dark = np.interp(times, course.time, course.light) < 0.5
        under = np.where(dark, latitude, np.nan)
        track(axes, longitude, under, color=SHADOW, alpha=0.35, linewidth=7.0, zorder=2)
        wide = 1.6 if task.mode == HARVEST else 3.2
        track(axes, longitude, latitude, color=COLOURS[task.mode], linewidth=wide, zorder=3)
        if task.site is None:
            continue
        place = np.degrees([task.site.longitude, task.site.latitude])
        axes.plot(*place, marker="x", color=COLOURS[task.mode], markersize=7, zorder=4)
    _names(axes, course.tasks)
    begin = _below(flown, np.array([course.tasks[0].start]))
    axes.plot(*np.degrees(begin[::-1]), marker="o", color="black", markersize=5, zorder=5)
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
    sites = {task.site: task.name for task in reversed(tasks) if task.site is not None}
    above = np.inf
    for site in sorted(sites, key=lambda site: -site.latitude):
        place = (float(np.degrees(site.longitude)), float(np.degrees(site.latitude)))
        above = min(place[1] - 1.0, above - _ROOM)
        axes.annotate(
            sites[site],
            place,
            xytext=(place[0] + 9.0, above),
            fontsize=8,
            va="center",
            zorder=6,
            arrowprops={"arrowstyle": "-", "color": "#777777", "linewidth": 0.5},
        )


def _legend(course: Course) -> list[Line2D]:
    modes = dict.fromkeys(task.mode for task in course.tasks)
    handles = [Line2D([], [], color=COLOURS[mode], linewidth=2.5, label=mode) for mode in modes]
    if (course.light < 0.5).any():
        handles.append(Line2D([], [], color=SHADOW, alpha=0.35, linewidth=7.0, label="eclipse"))
    handles.append(Line2D([], [], color="black", marker="o", linestyle="", label="start"))
    return handles
