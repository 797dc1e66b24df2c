"""Figures of a simulation: every quantity over time, and phase portraits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.records.wording import plural
from jaxatt.report.flight_record import FlightRecord
from jaxatt.report.flight_summary import AXES
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture

_RPM = 60.0 / (2.0 * np.pi)
_SHOWN = 200  # runs of which a phase portrait draws a line


def angles(result: FlightRecord) -> Floats:
    """Error angles 2 asin(eps) of every run, (R, records, 3) [deg]."""
    error = np.asarray(result.flown.recorded.error)
    return np.asarray(np.degrees(2.0 * np.arcsin(np.clip(error, -1.0, 1.0))))


def _series(result: FlightRecord) -> list[tuple[str, Floats, list[str]]]:
    flown = result.flown.recorded
    wheels = list(result.scenario.vehicle.wheels.names)
    start = np.asarray(result.scenario.initial.omega_bw)
    rows = [
        ("attitude error\n[deg]", angles(result), list(AXES)),
        ("rate error\n[deg/s]", np.degrees(np.asarray(flown.rate_error)), list(AXES)),
        ("wheel torque\n[mN m]", 1e3 * np.asarray(flown.wheel_torque), wheels),
        ("wheel speed, from\nthe start [rpm]", _RPM * (np.asarray(flown.omega_bw) - start), wheels),
    ]
    if result.scenario.dumping is not None:
        rows.append(("dipole\n[A m²]", np.asarray(flown.dipole), list(AXES)))
    return rows


def overview(result: FlightRecord) -> Picture:
    """Plot median and central 50 and 90 % of the runs that flew to the end, over time."""
    rows = _series(result)
    head = _head(result)
    if result.runs > 1:
        head += ", median with the middle 50 % and 90 %"
    figure = picture(9.0, 1.75 * len(rows) + 1.0, head)
    column = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (label, values, names) in zip(column, rows, strict=True):
        _bands(axes, result.record_times, values[result.sound], names)
        axes.set_ylabel(label)
        _command(axes, result)
    column[-1].set_xlabel("time [s]")
    figure.align_ylabels()
    return figure


def _head(result: FlightRecord) -> str:
    title = result.scenario.law_titles.get(result.law, result.law)
    return f"{result.scenario.title}\n{title}: {plural(result.runs, 'run')}"


def _bands(axes: Axes, time: Floats, values: Floats, names: list[str]) -> None:
    if len(values) == 0:
        axes.text(0.5, 0.5, "every run failed", ha="center", transform=axes.transAxes)
        return
    for index, name in enumerate(names):
        low, lower, middle, upper, high = np.percentile(
            values[..., index], (5.0, 25.0, 50.0, 75.0, 95.0), axis=0
        )
        style: dict[str, Any] = {"color": colour(index), "linewidth": 0}
        if len(values) > 1:
            axes.fill_between(time, low, high, alpha=0.15, **style)
            axes.fill_between(time, lower, upper, alpha=0.25, **style)
        axes.plot(time, middle, color=colour(index), linewidth=1.3, label=name)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
    axes.set_xlim(0.0, time[-1])
    axes.ticklabel_format(axis="y", scilimits=(-3, 4), useMathText=True)
    tidy(axes)


def _command(axes: Axes, result: FlightRecord) -> None:
    if result.scenario.asked.since > 0.0:
        axes.axvline(result.scenario.asked.since, color="#444444", linewidth=0.8, linestyle=":")


def phase_portrait(result: FlightRecord) -> Picture:
    """Plot rate error against attitude error, an axis a panel."""
    return portraits({result.law: result})


def portraits(results: Mapping[str, FlightRecord]) -> Picture:
    """Plot the phase portraits of several laws in the same panels."""
    first = next(iter(results.values()))
    moving = _moving(list(results.values()))
    head = first.scenario.title if len(results) > 1 else _head(first)
    drawn = min(_SHOWN, int(np.sum(first.sound)))
    if len(results) == 1 and drawn < first.runs:
        head += f", {drawn} drawn"
    figure = picture(2.0 + 3.0 * max(2, len(moving)), 3.8, head)
    row = figure.subplots(1, len(moving), squeeze=False)[0]
    for number, (name, result) in enumerate(results.items()):
        error, rate = angles(result), np.degrees(np.asarray(result.flown.recorded.rate_error))
        shown = np.flatnonzero(result.sound)[:_SHOWN]
        since = result.record_times >= result.scenario.asked.since
        alpha = 1.0 if len(shown) == 1 else max(0.08, 2.0 / max(1, len(shown)))
        for index, axes in zip(moving, row, strict=True):
            for k, run in enumerate(shown):
                axes.plot(
                    error[run, since, index],
                    rate[run, since, index],
                    color=colour(number),
                    linewidth=1.0,
                    alpha=alpha,
                    label=result.scenario.law_titles.get(name, name) if k == 0 else None,
                )
    for index, axes in zip(moving, row, strict=True):
        axes.plot(0.0, 0.0, "k+", markersize=8)
        axes.set_xlabel(f"attitude error {AXES[index]} [deg]")
        axes.locator_params(axis="x", nbins=6)
        tidy(axes)
    row[0].set_ylabel("rate error [deg/s]")
    if len(results) > 1:
        row[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)
    return figure


def _moving(results: list[FlightRecord]) -> list[int]:
    """Axes on which some run leaves the reference; all axes where none does."""
    largest = np.zeros(len(AXES))
    for result in results:
        rate = np.degrees(np.asarray(result.flown.recorded.rate_error))
        for values in (angles(result), rate):
            sizes = np.abs(values[result.sound]).max(axis=(0, 1), initial=0.0)
            largest = np.maximum(largest, sizes)
    found = np.flatnonzero(largest > 1e-9 * largest.max())
    return found.tolist() if len(found) else list(range(len(AXES)))


def compare(results: Mapping[str, FlightRecord]) -> Picture:
    """Plot nominal runs side by side, a column for each law."""
    first = next(iter(results.values()))
    rows = len(_series(first))
    figure = picture(4.2 * len(results), 1.9 * rows, first.scenario.title)
    grid = figure.subplots(rows, len(results), sharex=True, sharey="row", squeeze=False)
    for column, (name, result) in enumerate(results.items()):
        for axes, (label, values, names) in zip(grid[:, column], _series(result), strict=True):
            _bands(axes, result.record_times, values[result.sound][:1], names)
            _command(axes, result)
            legend = axes.get_legend()
            if column == 0:
                axes.set_ylabel(label)
            if column < len(results) - 1 and legend is not None:
                legend.remove()
        grid[0, column].set_title(result.scenario.law_titles.get(name, name), fontsize="medium")
        grid[-1, column].set_xlabel("time [s]")
    figure.align_ylabels(grid[:, 0])
    return figure
