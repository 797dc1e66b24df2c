"""One quantity of a result over time, drawn into given axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from jaxatt.attitude import euler
from jaxatt.drawing.figure import CHEAP, COAST, FORBIDDEN, colour, tidy
from jaxatt.problems.answer import Answer
from jaxatt.records.timeline import Timeline, timeline
from jaxatt.report.limits import body_torque_limit
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.settings import RUNS_ONCE

ANGLES = (r"$\phi$", r"$\theta$", r"$\psi$")
AXES = ("x", "y", "z")
_TORQUES = {"body": "body", "wheels": "wheel", "thrusters": "thruster"}
_RPM = 60.0 / (2.0 * np.pi)
_euler = jax.jit(euler.from_quaternion, compiler_options=RUNS_ONCE)


def shade(axes: Axes, result: Answer, legend: bool = True) -> None:
    """Shade windows and the coasting tail, and mark where a phase ends."""
    line = timeline(result.phases)
    priced = result.scenario.objective.kind == "moving-l0"
    cheap: dict[str, Any] = {"facecolor": CHEAP, "alpha": 0.45 if priced else 0.2, "linewidth": 0}
    forbidden: dict[str, Any] = {"facecolor": "none", "edgecolor": FORBIDDEN, "alpha": 0.5}
    forbidden["hatch"] = "///"
    handles: list[Artist] = []
    for mask, style, words in (
        (line.window, cheap, "cheap window" if priced else "window (not priced here)"),
        (line.forbidden, forbidden, "torque forbidden"),
    ):
        for first, last in _runs(mask):
            axes.axvspan(line.edges[first], line.edges[last], zorder=0, **style)
        if mask.any():
            handles.append(Patch(label=words, **style))
    if line.time[-1] > line.ends[-1] * (1 + 1e-9):
        axes.axvspan(line.ends[-1], line.time[-1], facecolor=COAST, zorder=0, linewidth=0)
        handles.append(Patch(facecolor=COAST, label="coasting"))
    for end in line.ends[:-1]:
        axes.axvline(end, color="black", linewidth=0.8, linestyle=(0, (6, 3)))
    if legend and len(line.ends) > 1:
        for number, (start, _) in enumerate(_spans(line), start=1):
            place: dict[str, Any] = {"xy": (start, 1.0), "xycoords": ("data", "axes fraction")}
            offset: dict[str, Any] = {"xytext": (4, 2), "textcoords": "offset points"}
            axes.annotate(f"leg {number}", **place, **offset, fontsize=8)
    if line.time[-1] > line.time[0]:
        axes.set_xlim(line.time[0], line.time[-1])
    tidy(axes)
    lines, _ = axes.get_legend_handles_labels()
    handles = [*lines, *handles] if legend else lines
    if handles:
        axes.legend(
            handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8
        )


def euler_angles(axes: Axes, result: Answer) -> None:
    """Roll, pitch and yaw with dotted references."""
    line = timeline(result.phases)
    angles = np.unwrap(np.asarray(_euler(line.nodes["q_ob"])), axis=0)
    _lines(axes, line.time, np.degrees(angles), ANGLES)
    for phase, (start, end) in zip(result.phases, _spans(line), strict=True):
        wanted = np.asarray(_euler(phase.reference["q_ob"]))
        at_end = angles[np.searchsorted(line.time, end - 1e-9)]
        _references(axes, start, end, np.degrees(_nearest_turn(wanted, at_end)))
    waypoint = result.scenario.waypoint
    if waypoint is not None:
        wanted = np.asarray(_euler(waypoint.q_ob))
        passing = waypoint.node * result.phases[0].step
        now = angles[np.searchsorted(line.time, passing - 1e-9)]
        for index, angle in enumerate(np.degrees(_nearest_turn(wanted, now))):
            label = "waypoint" if index == 0 else None
            ring: dict[str, Any] = {"facecolors": "none", "edgecolors": colour(index), "zorder": 4}
            axes.scatter(passing, angle, s=50, label=label, **ring)
    axes.set_ylabel("Euler angles\n[deg]")


def relative_rate(axes: Axes, result: Answer) -> None:
    """Rate of the body relative to the orbit frame."""
    line = timeline(result.phases)
    names = [rf"$\omega_{axis}$" for axis in AXES]
    _lines(axes, line.time, np.degrees(line.nodes["omega_ob"]), names)
    for phase, (start, end) in zip(result.phases, _spans(line), strict=True):
        _references(axes, start, end, np.degrees(phase.reference["omega_ob"]))
    frame = "ib" if result.scenario.orbit is None else "ob"
    axes.set_ylabel(rf"$\omega_{{{frame}}}^{{b}}$ [deg/s]")


def wheel_speeds(axes: Axes, result: Answer) -> None:
    """Speed of each wheel relative to the body, with limits where there are any."""
    line = timeline(result.phases)
    speeds = line.nodes["omega_bw"] * _RPM
    _lines(axes, line.time, speeds, [f"wheel {i + 1}" for i in range(speeds.shape[1])])
    vehicle = result.scenario.vehicle
    if vehicle is not None:
        limits = np.asarray(vehicle.wheels.speed_limit) * _RPM
        _limits(axes, np.unique(limits[np.isfinite(limits)]))
    axes.set_ylabel("wheel speeds\n[rpm]")


def states(axes: Axes, result: Answer) -> None:
    """States of a toy system with dotted references."""
    line = timeline(result.phases)
    values = line.nodes["state"]
    _lines(axes, line.time, values, [rf"$x_{i + 1}$" for i in range(values.shape[1])])
    for phase, (start, end) in zip(result.phases, _spans(line), strict=True):
        _references(axes, start, end, phase.reference["state"])
    axes.set_ylabel("state")


def pulses(
    axes: Axes,
    line: Timeline,
    values: Floats,
    index: int,
    label: str,
    limit: float,
    opacity: float = 0.55,
) -> None:
    """One piecewise constant control as filled steps, with its limits [unit of the values]."""
    style: dict[str, Any] = {"color": colour(index), "baseline": 0.0}
    axes.stairs(values, line.edges, fill=True, alpha=opacity, linewidth=0, **style)
    axes.stairs(values, line.edges, linewidth=1.4, label=label, **style)
    if np.isfinite(limit):
        _limits(axes, [limit])
    # Room for everything, but never so little that noise looks like a manoeuvre.
    widest = max(limit if np.isfinite(limit) else 0.0, float(np.abs(values).max()), 1e-12)
    bottom, top = axes.get_ylim()
    reach = 1.15 * widest
    if index:
        reach = max(reach, abs(bottom), abs(top))
    axes.set_ylim(-reach, reach)


def torque_rows(result: Answer, kind: str) -> list[tuple[Floats, str, float]]:
    """Values (I,), name and limit of each torque in mN m; "body", "wheels" or "thrusters"."""
    vehicle = result.scenario.vehicle
    assert vehicle is not None
    if kind == "thrusters":
        limit = np.asarray(vehicle.thrusters.torque_limit)
        names = [rf"$\tau_{{u,{i + 1}}}$" for i in range(len(limit))]
    elif kind == "body":
        limit = body_torque_limit(vehicle.wheels, result.scenario.control.axes == "body")
        names = [rf"$\tau_{{b,{axis}}}$" for axis in AXES]
    else:
        limit = np.asarray(vehicle.wheels.torque_limit)
        names = [rf"$\tau_{{w,{i + 1}}}$" for i in range(len(limit))]
    values = timeline(result.phases).intervals[f"torque_{kind}"]
    rows = zip(values.T * 1e3, names, limit * 1e3, strict=True)
    return [(row, name, float(most)) for row, name, most in rows]


def torque(axes: Axes, result: Answer, kind: str) -> None:
    """All torques of a kind in one panel."""
    line = timeline(result.phases)
    for index, (values, name, limit) in enumerate(torque_rows(result, kind)):
        pulses(axes, line, values, index, name, limit, opacity=0.15)
    if kind == "thrusters":
        axes.set_ylim(bottom=0.0)
    axes.set_ylabel(f"{_TORQUES[kind]} torque\n[mN m]")


def valves(axes: Axes, result: Answer) -> None:
    """When each thruster is open after quantisation, one row a thruster."""
    vehicle = result.scenario.vehicle
    assert vehicle is not None
    count = vehicle.thrusters.count
    for phase in result.phases:
        for found in phase.quantised[:1]:
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


def quaternion_components(axes: Axes, result: Answer) -> None:
    """Components of the attitude quaternion with dotted references, of the sign nearer the end."""
    line = timeline(result.phases)
    values = line.nodes["q_ob"]
    signs = np.cumprod(
        np.concatenate([[1.0], np.where(np.sum(values[1:] * values[:-1], axis=1) < 0, -1.0, 1.0)])
    )
    values = values * signs[:, None]
    _lines(axes, line.time, values, [r"$\eta$", *(rf"$\epsilon_{i}$" for i in (1, 2, 3))])
    for phase, (start, end) in zip(result.phases, _spans(line), strict=True):
        at_end = values[np.searchsorted(line.time, end - 1e-9)]
        wanted = phase.reference["q_ob"]
        _references(axes, start, end, wanted if wanted @ at_end >= 0.0 else -wanted)
    axes.set_ylabel("quaternion")


def control(axes: Axes, result: Answer) -> None:
    """Control of a toy system."""
    line = timeline(result.phases)
    pulses(axes, line, line.intervals["control"][:, 0], 0, "$u$", result.scenario.control.limit)
    axes.set_ylabel("control")


def _lines(axes: Axes, time: Floats, values: Floats, names: Sequence[str]) -> None:
    for index, name in enumerate(names):
        axes.plot(time, values[:, index], color=colour(index), linewidth=1.5, label=name)


def _references(axes: Axes, start: float, end: float, values: Floats) -> None:
    for index, value in enumerate(values):
        axes.hlines(value, start, end, colors=colour(index), linestyles="dotted", linewidth=1.4)


def _limits(axes: Axes, limits: Sequence[float] | Floats) -> None:
    for limit in limits:
        for sign in (-1.0, 1.0):
            axes.axhline(sign * limit, color="#444444", linewidth=0.8, linestyle=(0, (4, 3)))


def _spans(line: Timeline) -> list[tuple[float, float]]:
    return list(zip((line.edges[0], *line.ends[:-1]), line.ends, strict=True))


def _nearest_turn(angles: Floats, to: Floats) -> Floats:
    return np.asarray(angles + 2 * np.pi * np.round((to - angles) / (2 * np.pi)))


def _runs(mask: Flags) -> list[tuple[int, int]]:
    """First index and end of every run of true entries."""
    steps = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(first), int(end)) for first, end in steps.reshape(-1, 2)]
