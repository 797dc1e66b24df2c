"""Figures of a result: one overview, and one file for each quantity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.axes import Axes

from jaxatt.drawing.figure import Picture, picture, save
from jaxatt.problems.answer import Answer
from jaxatt.records.timeline import timeline
from jaxatt.records.wording import OBJECTIVES, plural
from jaxatt.report import panels, time_panels
from jaxatt.report.final_times import final_times_panels
from jaxatt.report.pointing_plot import pointing_figure
from jaxatt.report.starts_panel import starts_panel
from jaxatt.runtime.files import filling

Panel = Callable[[Axes, Answer], None]

_ATTITUDE: Mapping[str, Panel] = {
    "euler_angles": panels.euler_angles,
    "omega_ob": panels.relative_rate,
}
_WHEELS: Mapping[str, Panel] = {
    "torque_body": lambda axes, result: _torques(axes, result, "body"),
    "torque_wheels": lambda axes, result: _torques(axes, result, "wheels"),
    "wheel_speeds": panels.wheel_speeds,
}
_THRUSTERS: Mapping[str, Panel] = {
    "torque_thrusters": lambda axes, result: _torques(axes, result, "thrusters"),
}
_TOY: Mapping[str, Panel] = {"control": panels.control, "state": panels.states}


def plot(result: Answer) -> Picture:
    """Overview: every quantity over time, and how all starts ended."""
    chosen = list(_panels(result).values())
    phases = len(result.phases)
    figure = picture(9.0, 1.75 * len(chosen) + 3.2, headline(result))
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.75 * len(chosen), 2.6))[
        :, 0
    ]
    column = above.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for index, (axes, panel) in enumerate(zip(column, chosen, strict=True)):
        panel(axes, result)
        panels.shade(axes, result, legend=index == 0)
    column[-1].set_xlabel("time [s]")
    _starts(list(below.subplots(1, phases, squeeze=False)[0]), result)
    return figure


def figures(result: Answer) -> dict[str, Picture]:
    """Every figure by its name, the overview included."""
    made = {"overview": plot(result)}
    for name, panel in _panels(result).items():
        if name.startswith("torque_"):
            made[name] = _torque(result, name.removeprefix("torque_"))
            continue
        made[name] = picture(8.0, 3.6, result.scenario.title)
        axes = made[name].subplots()
        panel(axes, result)
        panels.shade(axes, result)
        axes.set_xlabel("time [s]")
    if any(phase.pointing is not None and phase.pointing.angles.size for phase in result.phases):
        made["pointing"] = pointing_figure(result)
    phases = len(result.phases)
    if any(phase.final_times is not None for phase in result.phases):
        made["final_times"] = picture(5.5 * phases, 5.5, result.scenario.title)
        grid = made["final_times"].subplots(2, phases, sharex="col", squeeze=False)
        for index, phase in enumerate(result.phases):
            final_times_panels(list(grid[:, index]), phase)
    made["starts"] = picture(5.5 * phases, 4.0, result.scenario.title)
    _starts(list(made["starts"].subplots(1, phases, squeeze=False)[0]), result)
    return made


def save_figures(result: Answer, folder: str | Path) -> list[Path]:
    """Write every figure as a PNG file into a folder; return the files."""
    made = figures(result)
    with filling(folder) as partial:
        for name, figure in made.items():
            save(figure, partial / f"{name}.png")
    return [Path(folder) / f"{name}.png" for name in sorted(made)]


def compare(results: Mapping[str, Answer]) -> Picture:
    """Answers side by side: a column for each controller, as the source's figures show them."""
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
    """One line for the head of a figure."""
    kind = OBJECTIVES[result.scenario.objective.kind]
    if result.phases[0].time_optimum is not None:
        found = ", ".join(f"{phase.final_time:.4f} s" for phase in result.phases)
        return f"{result.scenario.title}\n{kind}: {found}, {result.status}"
    count = result.active_intervals
    return f"{result.scenario.title}\n{kind}: {plural(count, 'active interval')}, {result.status}"


def _panels(result: Answer) -> Mapping[str, Panel]:
    vehicle = result.scenario.vehicle
    if vehicle is None:
        return _TOY
    chosen = dict(_ATTITUDE)
    if result.phases[0].time_optimum is not None:
        chosen = {"mrp": time_panels.modified_rodrigues, **chosen}
    if vehicle.thrusters.count:
        chosen = {"quaternion": panels.quaternion_components, **chosen, **_THRUSTERS}
        if any(phase.quantised for phase in result.phases):
            chosen["valves"] = panels.valves
    if vehicle.wheels.count:
        chosen |= _WHEELS
    return chosen


def _torques(axes: Axes, result: Answer, kind: str) -> None:
    """All torques of a kind in one panel, with their switches."""
    panels.torque(axes, result, kind)
    time_panels.mark_switches(axes, result, kind)


def _torque(result: Answer, kind: str) -> Picture:
    """One row for each torque, so that short pulses of different axes do not hide each other."""
    rows = panels.torque_rows(result, kind)
    line = timeline(result.phases)
    figure = picture(8.0, 1.4 * len(rows) + 1.2, result.scenario.title)
    grid = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for index, (axes, (values, name, limit)) in enumerate(zip(grid, rows, strict=True)):
        panels.pulses(axes, line, values, index, name, limit)
        time_panels.mark_switches(axes, result, kind, only=index)
        if kind == "thrusters":
            axes.set_ylim(bottom=0.0)
        panels.shade(axes, result, legend=index == 0)
    where = {"body": "in body axes", "wheels": "of the wheels", "thrusters": "of the thrusters"}
    figure.supylabel(f"torque {where[kind]} [mN m]", fontsize="medium")
    grid[-1].set_xlabel("time [s]")
    return figure


def _starts(row: list[Axes], result: Answer) -> None:
    toy = result.scenario.vehicle is None
    for index, (axes, phase) in enumerate(zip(row, result.phases, strict=True)):
        if phase.time_optimum is None:
            starts_panel(axes, phase, toy)
        else:
            time_panels.costs_panel(axes, phase)
        name = f"leg {index + 1}: " if len(result.phases) > 1 else ""
        axes.set_title(f"{name}{len(phase.starts.status)} starts", fontsize="medium")
