"""Panels that show one quantity of a system over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.attitude import euler
from jaxatt.drawing.figure import COAST, colour, tidy
from jaxatt.drawing.panels import QUATERNION, lines, pulses, references, runs, speed_limits
from jaxatt.problems.answer import Answer
from jaxatt.records.timeline import timeline
from jaxatt.report.family import sections_of
from jaxatt.report.limits import body_torque_limit
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.settings import RUNS_ONCE

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

ANGLES = ("roll φ", "pitch θ", "yaw ψ")
AXES = ("x", "y", "z")
_WORDS = {"body": "body", "wheels": "wheel", "thrusters": "thruster"}
TORQUES = tuple(f"torque_{kind}" for kind in _WORDS)
_RPM = 60.0 / (2.0 * np.pi)
_euler = Routine(euler.from_quaternion, options=RUNS_ONCE)


def shade(axes: Axes, result: Answer, legend: bool = True) -> None:
    """Shade the coasting tail and the family's windows, and mark the end of each phase."""
    from matplotlib.patches import Patch

    line = timeline(result.phases)
    handles: list[Artist] = []
    for shaded in sections_of(result).shades(result):
        for first, last in runs(shaded.mask):
            axes.axvspan(line.edges[first], line.edges[last], zorder=0, **shaded.style)
        if shaded.mask.any():
            handles.append(Patch(label=shaded.words, **shaded.style))
    if line.time[-1] > line.ends[-1] * (1 + 1e-9):
        axes.axvspan(line.ends[-1], line.time[-1], facecolor=COAST, zorder=0, linewidth=0)
        handles.append(Patch(facecolor=COAST, label="coasting"))
    for end in line.ends[:-1]:
        axes.axvline(end, color="black", linewidth=0.8, linestyle=(0, (6, 3)))
    if legend and len(line.ends) > 1:
        for number, (start, _) in enumerate(line.spans, start=1):
            place: dict[str, Any] = {"xy": (start, 1.0), "xycoords": ("data", "axes fraction")}
            offset: dict[str, Any] = {"xytext": (4, 2), "textcoords": "offset points"}
            axes.annotate(f"leg {number}", **place, **offset, fontsize=8)
    if line.time[-1] > line.time[0]:
        axes.set_xlim(line.time[0], line.time[-1])
    tidy(axes)
    drawn, _ = axes.get_legend_handles_labels()
    handles = [*drawn, *handles] if legend else drawn
    if handles:
        axes.legend(
            handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8
        )


def euler_angles(axes: Axes, result: Answer) -> None:
    """Draw roll, pitch and yaw with dotted references."""
    line, waypoint = timeline(result.phases), result.scenario.waypoint
    spans = zip(result.phases, line.spans, strict=True)
    aimed = [(phase.reference["q_ob"], span) for phase, span in spans if "q_ob" in phase.reference]
    passed = [] if waypoint is None else [waypoint.q_ob]
    flown, wanted = _angles(line.nodes["q_ob"], [*(q for q, _ in aimed), *passed])
    angles = np.unwrap(flown, axis=0)
    lines(axes, line.time, np.degrees(angles), ANGLES)
    for target, (_, (start, end)) in zip(wanted, aimed, strict=False):
        at_end = angles[np.searchsorted(line.time, end - 1e-9)]
        references(axes, start, end, np.degrees(_nearest_turn(target, at_end)))
    if waypoint is not None:
        passing = waypoint.node * result.phases[0].step
        now = angles[np.searchsorted(line.time, passing - 1e-9)]
        for index, angle in enumerate(np.degrees(_nearest_turn(wanted[-1], now))):
            label = "waypoint" if index == 0 else None
            ring: dict[str, Any] = {"facecolors": "none", "edgecolors": colour(index), "zorder": 4}
            axes.scatter(passing, angle, s=50, label=label, **ring)
    axes.set_ylabel("Euler angles\n[deg]")


def _angles(flown: Floats, wanted: Sequence[Floats]) -> tuple[Floats, Floats]:
    """Euler angles of attitudes (K, 4) and of further ones, (4,) each, by one compiled call."""
    every = np.asarray(_euler(np.concatenate([flown, *(q[None] for q in wanted)])))
    return every[: len(flown)], every[len(flown) :]


def relative_rate(axes: Axes, result: Answer) -> None:
    """Draw the rate of the body relative to the orbit frame."""
    line = timeline(result.phases)
    lines(axes, line.time, np.degrees(line.nodes["omega_ob"]), AXES)
    for phase, (start, end) in zip(result.phases, line.spans, strict=True):
        if "omega_ob" in phase.reference:
            references(axes, start, end, np.degrees(phase.reference["omega_ob"]))
    frame = "inertial" if result.scenario.orbit is None else "orbit"
    axes.set_ylabel(f"rate to {frame}\nframe [deg/s]")


def wheel_speeds(axes: Axes, result: Answer) -> None:
    """Draw the speed of each wheel relative to the body, with limits where there are any."""
    line = timeline(result.phases)
    vehicle = result.scenario.vehicle
    if vehicle is not None:
        lines(axes, line.time, line.nodes["omega_bw"] * _RPM, vehicle.wheels.names)
        speed_limits(axes, vehicle.wheels, _RPM)
    axes.set_ylabel("wheel speeds\n[rpm]")


def torque_rows(result: Answer, kind: str) -> list[tuple[Floats, str, float]]:
    """Values (I,), name and limit of each torque [mN m]; kind : "body", "wheels" or "thrusters"."""
    vehicle = result.scenario.vehicle
    assert vehicle is not None
    if kind == "thrusters":
        limit = np.asarray(vehicle.thrusters.torque_limit)
        names = [f"thruster {i + 1}" for i in range(len(limit))]
    elif kind == "body":
        limit = body_torque_limit(vehicle.wheels, result.scenario.control.axes == "body")
        names = list(AXES)
    else:
        limit = np.asarray(vehicle.wheels.torque_limit)
        names = list(vehicle.wheels.names)
    values = timeline(result.phases).intervals[f"torque_{kind}"]
    rows = zip(values.T * 1e3, names, limit * 1e3, strict=True)
    return [(row, name, float(most)) for row, name, most in rows]


def torque(axes: Axes, result: Answer, kind: str) -> None:
    """Draw all torques of a kind in one panel."""
    line = timeline(result.phases)
    for index, (values, name, limit) in enumerate(torque_rows(result, kind)):
        pulses(axes, line.edges, values, index, name, limit, opacity=0.15)
    if kind == "thrusters":
        axes.set_ylim(bottom=0.0)
    axes.set_ylabel(f"{_WORDS[kind]} torque\n[mN m]")


def quaternion_components(axes: Axes, result: Answer) -> None:
    """Draw the attitude quaternion with dotted references, in the sign nearer the end."""
    line = timeline(result.phases)
    values = line.nodes["q_ob"]
    signs = np.cumprod(
        np.concatenate([[1.0], np.where(np.sum(values[1:] * values[:-1], axis=1) < 0, -1.0, 1.0)])
    )
    values = values * signs[:, None]
    lines(axes, line.time, values, QUATERNION)
    for phase, (start, end) in zip(result.phases, line.spans, strict=True):
        if "q_ob" not in phase.reference:
            continue
        at_end = values[np.searchsorted(line.time, end - 1e-9)]
        wanted = phase.reference["q_ob"]
        references(axes, start, end, wanted if wanted @ at_end >= 0.0 else -wanted)
    axes.set_ylabel("quaternion")


def _nearest_turn(angles: Floats, to: Floats) -> Floats:
    return np.asarray(angles + 2 * np.pi * np.round((to - angles) / (2 * np.pi)))


def nodes(axes: Axes, result: Answer, name: str) -> None:
    """Draw any series at nodes, with its dotted target where it has one."""
    line = timeline(result.phases)
    values = _columns(line.nodes[name])
    lines(axes, line.time, values, _names(name, values))
    for phase, (start, end) in zip(result.phases, line.spans, strict=True):
        if name in phase.reference:
            references(axes, start, end, np.ravel(phase.reference[name]))
    axes.set_ylabel(name)


def intervals(axes: Axes, result: Answer, name: str) -> None:
    """Draw any series that is held over intervals."""
    line = timeline(result.phases)
    values = _columns(line.intervals[name])
    for index, words in enumerate(_names(name, values)):
        pulses(axes, line.edges, values[:, index], index, words, np.inf, opacity=0.15)
    axes.set_ylabel(name)


def _columns(values: Floats) -> Floats:
    return np.reshape(values, (len(values), -1))


def _names(name: str, values: Floats) -> list[str]:
    count = values.shape[1]
    return [name] if count == 1 else [f"{name} {i + 1}" for i in range(count)]
