"""Panels of a manoeuvre that earns energy: power, energy, attitude, rates, battery, starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import colour, no_rounding, tidy, whole_ticks
from jaxatt.drawing.panels import QUATERNION, lines, references
from jaxatt.problems.answer import Answer
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.sections import Panel, Shade
from jaxatt.records.phase import Phase
from jaxatt.records.timeline import timeline
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DASHED: dict[str, Any] = {"color": "#555555", "linewidth": 1.2, "linestyle": (0, (4, 2))}
_DARK: dict[str, Any] = {"facecolor": "#D9D9D9", "linewidth": 0}


def panels(answer: Answer, common: Mapping[str, Panel]) -> dict[str, Panel]:
    """Panels of power and energy first, then those of the motion that any answer has."""
    series = timeline(answer.phases).nodes
    chosen: dict[str, Panel] = {"power": power, "net_energy": net_energy}
    if "charge" in series:
        chosen["charge"] = charge
    chosen |= {"quaternion": attitude, "rates": rates}
    if "dipole" in series:
        chosen["dipole"] = dipole
    kept = ("torque_wheels", "wheel_speeds")
    return chosen | {name: common[name] for name in kept if name in common}


def power(axes: Axes, answer: Answer) -> None:
    """Draw solar, actuation and net power, and the baseline's net power."""
    line = timeline(answer.phases)
    for index, (name, words) in enumerate(
        (("solar_power", "solar"), ("actuation_power", "actuation"), ("net_power", "net"))
    ):
        axes.plot(line.time, line.nodes[name], color=colour(index), linewidth=1.4, label=words)
    _baseline(axes, answer, "net_power", "net, PD law")
    axes.set_ylabel("power [W]")


def net_energy(axes: Axes, answer: Answer) -> None:
    """Draw the net energy from the start, and the baseline's."""
    time, values = cumulative(answer, "net_energy")
    axes.plot(time, values, color=colour(0), linewidth=1.6, label="optimum")
    if all("net_energy" in net_power(phase).baseline for phase in answer.phases):
        time, values = cumulative(answer, "net_energy", of_baseline=True)
        axes.plot(time, values, label="PD law", **_DASHED)
    axes.set_ylabel("net energy\n[J]")


def cumulative(answer: Answer, name: str, of_baseline: bool = False) -> tuple[Floats, Floats]:
    """Time and a series that counts from each phase's start, added up over the phases."""
    times, values, before = [], [], 0.0
    for phase in answer.phases:
        series = net_power(phase).baseline if of_baseline else phase.series
        own = before + np.asarray(series[name])
        times.append(phase.start_time + phase.step * np.arange(len(own)))
        values.append(own)
        before = float(own[-1])
    return np.concatenate(times), np.concatenate(values)


def charge(axes: Axes, answer: Answer) -> None:
    """Draw the charge of the battery, with its floor and its capacity."""
    line = timeline(answer.phases)
    axes.plot(line.time, line.nodes["charge"] / 3600.0, color=colour(0), linewidth=1.5)
    options, craft = answer.scenario.options, answer.scenario.vehicle
    marks = [options.floor]
    if craft is not None and craft.battery is not None:
        marks.append(float(craft.battery.capacity))
    for mark in marks:
        if np.isfinite(mark):
            axes.axhline(mark / 3600.0, color="#444444", linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_ylabel("charge [Wh]")


def attitude(axes: Axes, answer: Answer) -> None:
    """Draw the inertial attitude quaternion with dotted references, without jumps of its sign."""
    line = timeline(answer.phases)
    q = line.nodes["q_ib"]
    same = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    q = q * np.concatenate([[1.0], np.cumprod(same)])[:, None]
    lines(axes, line.time, q, QUATERNION)
    for phase, (start, end) in zip(answer.phases, line.spans, strict=True):
        if "q_ib" in phase.reference:
            at_end = q[np.searchsorted(line.time, end - 1e-9)]
            wanted = phase.reference["q_ib"]
            references(axes, start, end, wanted if wanted @ at_end >= 0.0 else -wanted)
    axes.set_ylabel("quaternion")


def rates(axes: Axes, answer: Answer) -> None:
    """Draw the rate relative to the inertial frame."""
    line = timeline(answer.phases)
    lines(axes, line.time, np.degrees(line.nodes["omega_ib"]), "xyz")
    for phase, (start, end) in zip(answer.phases, line.spans, strict=True):
        if "omega_ib" in phase.reference:
            references(axes, start, end, np.degrees(phase.reference["omega_ib"]))
    axes.set_ylabel("rate to inertial\nframe [deg/s]")


def dipole(axes: Axes, answer: Answer) -> None:
    """Draw the dipole of the magnetorquers."""
    line = timeline(answer.phases)
    lines(axes, line.time, line.nodes["dipole"], "xyz")
    axes.set_ylabel("dipole [A m²]")


def shades(answer: Answer) -> tuple[Shade, ...]:
    """The Earth's shadow."""
    light = timeline(answer.phases).nodes["light"]
    count = len(timeline(answer.phases).edges) - 1
    return (Shade(np.asarray(light[:count] < 0.5), "in the Earth's shadow", _DARK),)


def starts_panel(axes: Axes, phase: Phase) -> None:
    """Draw the net energy or the cost of every start from the best to the worst."""
    found, starts = net_power(phase), phase.starts
    costly, reached = found.cost is not None, starts.reached
    # Where everything missed counts as much as in the cost, hopeless starts would hide the others.
    shown = np.where(reached | (not costly), found.start_score, np.nan)
    order = np.argsort(np.where(np.isfinite(shown), -shown, np.inf), kind="stable")
    rank, value = 1 + np.arange(len(order)), shown[order] * (-1.0 if costly else 1.0)
    for mask, marker, index, words in (
        (~reached[order], "x", 1, "not reached"),
        (reached[order], "o", 0, "reached"),
    ):
        if mask.any():
            style: dict[str, Any] = {"s": 20, "color": colour(index), "marker": marker}
            axes.scatter(rank[mask], value[mask], label=f"{words} ({int(mask.sum())})", **style)
    best = found.energy.net if found.cost is None else found.cost
    axes.axhline(best, color="#444444", linewidth=0.8, linestyle=(0, (4, 3)))
    no_rounding(axes, best)
    words = "cost" if costly else "energy"
    axes.set_xlabel(f"starts in order of {words} ({100 * found.share:.0f} % at the best)")
    axes.set_ylabel("cost" if costly else "net energy [J]")
    whole_ticks(axes.xaxis)
    axes.legend(fontsize=8, frameon=False, loc="best")
    tidy(axes)


def _baseline(axes: Axes, answer: Answer, name: str, words: str) -> None:
    for index, phase in enumerate(answer.phases):
        values = net_power(phase).baseline.get(name)
        if values is not None:
            time = phase.start_time + phase.step * np.arange(len(values))
            axes.plot(time, values, label=None if index else words, **_DASHED)
