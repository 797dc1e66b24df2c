"""Figures of a result: an overview, and one figure for each quantity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.figure import picture, save
from jaxatt.drawing.panels import pulses
from jaxatt.problems.answer import Answer
from jaxatt.problems.sections import Panel
from jaxatt.records.phase import Phase
from jaxatt.records.timeline import timeline
from jaxatt.records.wording import objective_title
from jaxatt.report import panels
from jaxatt.report.family import sections_of
from jaxatt.report.pointing_plot import pointing_figure
from jaxatt.report.starts_panel import starts_panel
from jaxatt.runtime.files import filling

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture


class Figures(StrEnum):
    """Which figures of a result are drawn."""

    none = "none"
    overview = "overview"
    all = "all"


_SPACECRAFT: Mapping[str, tuple[str, Panel]] = {
    "quaternion": ("torque_thrusters", panels.quaternion_components),
    "euler_angles": ("q_ob", panels.euler_angles),
    "omega_ob": ("omega_ob", panels.relative_rate),
    "torque_thrusters": (
        "torque_thrusters",
        lambda axes, result: _torques(axes, result, "thrusters"),
    ),
    "torque_body": ("torque_body", lambda axes, result: _torques(axes, result, "body")),
    "torque_wheels": ("torque_wheels", lambda axes, result: _torques(axes, result, "wheels")),
    "wheel_speeds": ("omega_bw", panels.wheel_speeds),
}
"""Panels of a spacecraft in their order, each with the series without which there is none."""

_DRAWN = ("q_ob", "omega_ob", "omega_ib", "omega_bw", *panels.TORQUES)
"""Series of a spacecraft that those panels show, or that need none of their own."""

_ABREAST = 4
"""Panels of starts side by side."""


def plot(result: Answer) -> Picture:
    """Plot the overview: every quantity over time, and the outcome of all starts."""
    own = sections_of(result).overview(result)
    if own is not None:
        return own
    chosen = list(_panels(result).values())
    figure = picture(9.0, 1.75 * len(chosen) + 3.2, headline(result))
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.75 * len(chosen), 2.6))[
        :, 0
    ]
    column = above.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for index, (axes, panel) in enumerate(zip(column, chosen, strict=True)):
        panel(axes, result)
        panels.shade(axes, result, legend=index == 0)
    column[-1].set_xlabel("time [s]")
    _starts(list(below.subplots(1, len(_searched(result)), squeeze=False)[0]), result)
    return figure


def figures(result: Answer) -> dict[str, Callable[[], Picture]]:
    """What draws each figure, by its name; the overview is the first."""
    made: dict[str, Callable[[], Picture]] = {"overview": partial(plot, result)}
    for name, panel in _panels(result).items():
        if name in panels.TORQUES and result.scenario.vehicle is not None:
            made[name] = partial(_torque, result, name.removeprefix("torque_"))
        else:
            made[name] = partial(_alone, result, panel)
    if any(phase.pointing is not None and phase.pointing.angles.size for phase in result.phases):
        made["pointing"] = partial(pointing_figure, result)
    return {**made, **sections_of(result).figures(result), "starts": partial(_all_starts, result)}


def save_figures(
    result: Answer, folder: str | Path, which: Figures | str = Figures.all
) -> list[Path]:
    """Write figures as PNG files into a folder; return the files.

    Those of an earlier result that are not drawn again are removed.
    """
    known = figures(result)
    drawn = {Figures.none: [], Figures.overview: ["overview"], Figures.all: sorted(known)}[
        Figures(which)
    ]
    for name in known.keys() - set(drawn):
        (Path(folder) / f"{name}.png").unlink(missing_ok=True)
    with filling(folder) as unfinished:
        for name in drawn:
            save(known[name](), unfinished / f"{name}.png")
    return [Path(folder) / f"{name}.png" for name in drawn]


def compare(results: Mapping[str, Answer]) -> Picture:
    """Plot answers side by side, a column for each controller, as in the source's figures."""
    chosen = list(_panels(next(iter(results.values()))).values())
    title = next(iter(results.values())).scenario.title
    figure = picture(5.2 * len(results), 2.1 * len(chosen), title)
    grid = figure.subplots(len(chosen), len(results), sharex=True, sharey="row", squeeze=False)
    for column, (name, result) in enumerate(results.items()):
        last = column == len(results) - 1
        for row, panel in enumerate(chosen):
            axes = grid[row, column]
            panel(axes, result)
            panels.shade(axes, result, legend=row == 0)
            legend = axes.get_legend()
            if legend is not None and not last:
                legend.remove()
            if column:
                axes.set_ylabel("")
        grid[0, column].set_title(name)
        grid[-1, column].set_xlabel("time [s]")
    return figure


def headline(result: Answer) -> str:
    """Two title lines of a figure."""
    kind = objective_title(result.scenario.objective.kind)
    found = result.phases[0].section.headline(result.phases)
    return f"{result.scenario.title}\n{kind}: {found}, {result.status}"


def _panels(result: Answer) -> Mapping[str, Panel]:
    return sections_of(result).panels(result, _common(result))


def _common(result: Answer) -> Mapping[str, Panel]:
    """Panels that any answer of such a system has: the spacecraft's, then any other series."""
    vehicle, line = result.scenario.vehicle, timeline(result.phases)
    chosen: dict[str, Panel] = {}
    if vehicle is not None:
        flown = {name for name, values in result.phases[0].series.items() if np.size(values)}
        chosen = {name: panel for name, (series, panel) in _SPACECRAFT.items() if series in flown}
    drawn = () if vehicle is None else _DRAWN
    for series, draw in ((line.intervals, panels.intervals), (line.nodes, panels.nodes)):
        chosen |= {name: _any(draw, name) for name in series if name not in drawn}
    return chosen


def _any(draw: Callable[[Axes, Answer, str], None], name: str) -> Panel:
    return lambda axes, result: draw(axes, result, name)


def _alone(result: Answer, panel: Panel) -> Picture:
    """Plot one panel as a figure of its own."""
    figure = picture(8.0, 3.6, result.scenario.title)
    axes = figure.subplots()
    panel(axes, result)
    panels.shade(axes, result)
    axes.set_xlabel("time [s]")
    return figure


def _torques(axes: Axes, result: Answer, kind: str) -> None:
    """Draw all torques of a kind in one panel, with the family's marks."""
    panels.torque(axes, result, kind)
    sections_of(result).mark(axes, result, kind, None)


def _torque(result: Answer, kind: str) -> Picture:
    """Plot one row for each torque, so that short pulses of different axes stay visible."""
    rows = panels.torque_rows(result, kind)
    line = timeline(result.phases)
    figure = picture(8.0, 1.4 * len(rows) + 1.2, result.scenario.title)
    grid = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for index, (axes, (values, name, limit)) in enumerate(zip(grid, rows, strict=True)):
        pulses(axes, line.edges, values, index, name, limit)
        sections_of(result).mark(axes, result, kind, index)
        if kind == "thrusters":
            axes.set_ylim(bottom=0.0)
        panels.shade(axes, result, legend=index == 0)
    where = {"body": "in body axes", "wheels": "of the wheels", "thrusters": "of the thrusters"}
    figure.supylabel(f"torque {where[kind]} [mN m]", fontsize="medium")
    grid[-1].set_xlabel("time [s]")
    return figure


def _searched(result: Answer) -> list[tuple[int, Phase]]:
    """Number and record of the phases that were solved from several starts, or of all phases."""
    numbered = list(enumerate(result.phases, start=1))
    return [(k, phase) for k, phase in numbered if len(phase.starts.status) > 1] or numbered


def _all_starts(result: Answer) -> Picture:
    count = len(_searched(result))
    rows, columns = -(-count // _ABREAST), min(count, _ABREAST)
    figure = picture(5.5 * columns, 4.0 * rows, result.scenario.title)
    _starts(list(figure.subplots(rows, columns, squeeze=False).flat), result)
    return figure


def _starts(places: list[Axes], result: Answer) -> None:
    own, unitless = sections_of(result).starts, result.scenario.vehicle is None
    searched = _searched(result)
    for axes, (number, phase) in zip(places, searched, strict=False):
        if own is None:
            starts_panel(axes, phase, unitless)
        else:
            own(axes, phase)
        name = f"leg {number}: " if len(result.phases) > 1 else ""
        axes.set_title(f"{name}{len(phase.starts.status)} starts", fontsize="medium")
    for axes in places[len(searched) :]:
        axes.set_axis_off()
