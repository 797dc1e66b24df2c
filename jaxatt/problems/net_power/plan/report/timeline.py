"""Figure of a plan over time: tasks, power, energy, charge and wheel speeds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.drawing.panels import lines, runs, speed_limits
from jaxatt.environment.epoch import SECONDS_PER_DAY
from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.modes import COMMUNICATE, HARVEST, IDLE, IMAGE
from jaxatt.problems.net_power.plan.report.course import Course
from jaxatt.spacecraft.wheels import ReactionWheels, no_wheels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture


COLOURS = {HARVEST: "#F7E7B0", IMAGE: "#BFE3D3", COMMUNICATE: "#BBD7EE", IDLE: "#E4E4E4"}
"""Of the modes of operation."""

SHADOW = "#5A5A6E"
_SPACINGS = (10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 21600.0)
_TICKS = 10
_RPM = 60.0 / (2.0 * np.pi)
_SHORT = 0.012
"""Share of the plan below which a task's name is written upright."""

Panel = Callable[["Axes", Course], None]


def timeline_figure(course: Course, title: str, wheels: ReactionWheels | None = None) -> Picture:
    """Draw a plan over time.

    title : one line or two.  wheels : their names, speed limits and bands.
    """
    panels: list[tuple[Panel, float]] = [(_power, 1.3), (_energy, 1.3)]
    if np.isfinite(course.capacity):
        panels.append((_charge, 0.9))
    panels += [(_rate, 0.8), (lambda axes, drawn: _speeds(axes, drawn, wheels), 1.2)]
    heights = [0.8, *(height for _, height in panels)]
    figure = picture(12.0, 1.55 * sum(heights), title)
    column = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    bands(column[0], course)
    for axes, (panel, _) in zip(column[1:], panels, strict=True):
        panel(axes, course)
        _shade(axes, course)
        tidy(axes)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.align_ylabels(column[1:])
    column[-1].set_xlim(course.time[0], course.time[-1])
    clock(column[-1], course.days)
    return figure


def bands(axes: Axes, course: Course) -> None:
    """Draw the tasks as bands with their names, and the Earth's shadow below them."""
    from matplotlib.patches import Patch

    whole = course.tasks[-1].end
    for task in course.tasks:
        axes.axvspan(task.start, task.end, ymin=0.12, color=COLOURS[task.mode], linewidth=0)
        if task.mode == HARVEST:
            continue
        upright = task.duration < _SHORT * whole * len(task.name)
        axes.text(
            0.5 * (task.start + task.end),
            0.56,
            task.name,
            transform=axes.get_xaxis_transform(),
            rotation=90 if upright else 0,
            ha="center",
            va="center",
            fontsize=7,
        )
    for first, last in _eclipses(course):
        axes.axvspan(first, last, ymax=0.12, color=SHADOW, linewidth=0)
    axes.set_yticks([])
    axes.spines[["top", "right", "left"]].set_visible(False)
    modes = dict.fromkeys(task.mode for task in course.tasks)
    handles = [Patch(color=COLOURS[mode], label=mode) for mode in modes]
    if (course.light < 1.0).any():
        handles.append(Patch(color=SHADOW, label="eclipse"))
    axes.legend(
        handles=handles, frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5)
    )


def clock(axes: Axes, days: float | None) -> None:
    """Label the axis of time by the clock, or in seconds where there is none."""
    if days is None:
        axes.set_xlabel("time [s]")
        return
    first, last = axes.get_xlim()
    spacing = next((s for s in _SPACINGS if last - first <= _TICKS * s), _SPACINGS[-1])
    midnight = -((days + 0.5) % 1.0) * SECONDS_PER_DAY
    ticks = midnight + spacing * np.arange(
        np.ceil((first - midnight) / spacing), np.floor((last - midnight) / spacing) + 1
    )
    texts = [clock_text(tick, days) for tick in ticks]
    axes.set_xticks(ticks, [text[:5] if spacing >= 60.0 else text for text in texts])
    axes.set_xlabel("time [UTC]")


def _eclipses(course: Course) -> list[tuple[float, float]]:
    """Times [s] between which less than the whole sun is seen."""
    found = runs(course.light < 1.0)
    last = len(course.time) - 1
    return [(course.time[a], course.time[min(b, last)]) for a, b in found]


def _shade(axes: Axes, course: Course) -> None:
    for first, last in _eclipses(course):
        axes.axvspan(first, last, color=SHADOW, alpha=0.14, linewidth=0, zorder=0)
    for task in course.tasks:
        if task.mode != HARVEST:
            axes.axvspan(
                task.start, task.end, color=COLOURS[task.mode], alpha=0.5, linewidth=0, zorder=0
            )


def _power(axes: Axes, course: Course) -> None:
    axes.plot(course.time, course.solar_power, color=colour(4), linewidth=1.2, label="solar")
    axes.plot(course.time, course.net_power, color=colour(0), linewidth=1.2, label="net")
    axes.axhline(0.0, color="#444444", linewidth=0.8)
    axes.set_ylabel("power [W]")


def _energy(axes: Axes, course: Course) -> None:
    """Draw the energy since the plan's start, whose last values the legend tells."""
    label = f"plan: {course.energy[-1]:.1f} J"
    axes.plot(course.time, 1e-3 * course.energy, color=colour(0), linewidth=1.6, label=label)
    if np.isfinite(course.baseline).any():
        label = f"PD law: {course.baseline[-1]:.1f} J"
        values = 1e-3 * course.baseline
        axes.plot(course.time, values, color=colour(1), linestyle="--", linewidth=1.3, label=label)
    axes.axhline(0.0, color="#444444", linewidth=0.8)
    axes.set_ylabel("net energy\n[kJ]")


def _charge(axes: Axes, course: Course) -> None:
    axes.plot(course.time, 100.0 * course.charge / course.capacity, color=colour(2), linewidth=1.6)
    if np.isfinite(course.floor):
        floor = 100.0 * course.floor / course.capacity
        axes.axhline(floor, color=colour(1), linewidth=1.0, linestyle=(0, (4, 3)), label="floor")
    axes.set_ylabel("charge [%]")


def _rate(axes: Axes, course: Course) -> None:
    axes.plot(course.time, np.degrees(course.rate), color=colour(6), linewidth=1.0)
    axes.set_ylabel("rate [deg/s]")


def _speeds(axes: Axes, course: Course, wheels: ReactionWheels | None) -> None:
    speeds = course.wheel_speed * _RPM
    names = no_wheels().names if wheels is None else wheels.names
    lines(axes, course.time, speeds, names)
    if wheels is not None:
        speed_limits(axes, wheels, _RPM)
    axes.set_ylabel("wheel speeds\n[rpm]")
