"""Panels and figures of an answer of sparse control."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import CHEAP, FORBIDDEN, colour, picture
from jaxatt.problems.answer import Answer
from jaxatt.problems.hands_off.record import sparse_section
from jaxatt.problems.hands_off.report.final_times import final_times_panels
from jaxatt.problems.sections import Panel, Shade

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture


def shades(answer: Answer) -> tuple[Shade, ...]:
    """Shades of cheap windows, fainter where they are not priced, and of forbidden ones."""
    priced = answer.scenario.objective.kind == "moving-l0"
    cheap: dict[str, Any] = {"facecolor": CHEAP, "alpha": 0.45 if priced else 0.2, "linewidth": 0}
    forbidden: dict[str, Any] = {"facecolor": "none", "edgecolor": FORBIDDEN, "alpha": 0.5}
    forbidden["hatch"] = "///"
    found = [sparse_section(phase) for phase in answer.phases]
    words = "cheap window" if priced else "window (not priced here)"
    return (
        Shade(np.concatenate([section.window for section in found]), words, cheap),
        Shade(
            np.concatenate([section.forbidden for section in found]), "torque forbidden", forbidden
        ),
    )


def panels(answer: Answer, common: Mapping[str, Panel]) -> dict[str, Panel]:
    """Panels of any answer, with the valves below the thrusters' torques."""
    chosen: dict[str, Panel] = {}
    for name, panel in common.items():
        chosen[name] = panel
        quantised = any(sparse_section(phase).quantised for phase in answer.phases)
        if name == "torque_thrusters" and quantised:
            chosen["valves"] = valves
    return chosen


def valves(axes: Axes, answer: Answer) -> None:
    """Draw when each thruster is open after quantisation, one row a thruster."""
    vehicle = answer.scenario.vehicle
    assert vehicle is not None
    count = vehicle.thrusters.count
    for phase in answer.phases:
        for found in sparse_section(phase).quantised[:1]:
            starts = phase.start_time + phase.step * np.arange(len(found.opens))
            for j in range(count):
                spans = np.stack([starts + found.opens[:, j], (found.shuts - found.opens)[:, j]])
                open_now = spans[1] > 0.0
                axes.broken_barh(
                    spans[:, open_now].T.tolist(), (j + 0.6, 0.8), facecolors=colour(j)
                )
    axes.set_yticks(range(1, count + 1))
    axes.set_ylim(count + 0.6, 0.4)
    axes.set_ylabel("open valves")


def figures(answer: Answer) -> dict[str, Callable[[], Picture]]:
    """Figure of cost and active intervals against the final times that were tried, if any."""
    if all(sparse_section(phase).final_times is None for phase in answer.phases):
        return {}
    return {"final_times": partial(_final_times, answer)}


def _final_times(answer: Answer) -> Picture:
    phases = len(answer.phases)
    figure = picture(5.5 * phases, 5.5, answer.scenario.title)
    grid = figure.subplots(2, phases, sharex="col", squeeze=False)
    for index, phase in enumerate(answer.phases):
        final_times_panels(list(grid[:, index]), phase)
    return figure
