"""Figure of pointing limits: angles of the cones over time, and boresights on a sky map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.figure import COAST, colour, picture, tidy
from jaxatt.problems.answer import Answer
from jaxatt.records.pointing import PointingRecord
from jaxatt.records.wording import limit_label
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture

_RING = 361


def pointing_figure(result: Answer) -> Picture:
    """Plot angles over time above sky maps in inertial axes, one column a cone."""
    count = max(
        phase.pointing.angles.shape[1] for phase in result.phases if phase.pointing is not None
    )
    figure = picture(max(8.0, 5.2 * count), 7.0, result.scenario.title)
    above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(1.0, 1.15))[:, 0]
    upper = above.subplots(1, count, squeeze=False)[0]
    lower = below.subplots(1, count, squeeze=False, subplot_kw={"projection": "mollweide"})[0]
    for index in range(count):
        _angles(upper[index], result, index)
        _map(lower[index], result, index)
    return figure


def _angles(axes: Axes, result: Answer, index: int) -> None:
    """Draw the angle of one cone over time, with the forbidden range shaded."""
    end = 0.0
    for phase in result.phases:
        record = phase.pointing
        assert record is not None
        time = phase.start_time + record.time
        if phase is not result.phases[-1]:
            time = time[time <= phase.start_time + phase.step * len(phase.active) + 1e-9]
        axes.plot(time, np.degrees(record.angles[: len(time), index]), color=colour(0))
        worst = record.extremes[index]
        axes.plot(
            phase.start_time + worst.time,
            np.degrees(worst.value),
            "o",
            color=colour(1),
            label=f"{np.degrees(worst.value):.4g} deg" if phase is result.phases[0] else None,
        )
        end = phase.start_time + phase.step * len(phase.active)
    allowed = np.degrees(worst.allowed)
    low, high = axes.get_ylim()
    out = worst.kind == "keep-out"
    low, high = (max(0.0, min(low, allowed - 10.0)), max(high, allowed + 10.0))
    axes.axhspan(
        low if out else allowed,
        allowed if out else high,
        facecolor="#D55E00",
        alpha=0.18,
        linewidth=0,
        label="forbidden",
    )
    if time[-1] > end * (1 + 1e-9):
        axes.axvspan(end, time[-1], facecolor=COAST, zorder=0, linewidth=0, label="coasting")
    axes.set_ylim(low, min(180.0, high))
    axes.set_xlim(0.0, time[-1])
    axes.set_xlabel("time [s]")
    axes.set_ylabel("angle [deg]")
    axes.set_title(limit_label(worst.kind, worst.name), fontsize="medium")
    tidy(axes)
    axes.legend(frameon=False, fontsize=8)


def _map(axes: Axes, result: Answer, index: int) -> None:
    """Draw the path of a boresight on the sky, with the cone at its closest instant."""
    for phase in result.phases:
        record = phase.pointing
        assert record is not None
        count = int(np.searchsorted(record.time, phase.step * len(phase.active) + 1e-9))
        _curve(axes, record.boresights[:count, index], "-", 0, "boresight")
        for step, mark, words in ((0, "o", "start"), (count - 1, "s", "end")):
            _points(axes, record.boresights[step : step + 1, index], mark, 0, words)
        _cone(axes, record, index)
    axes.grid(True, color="#E6E6E6", linewidth=0.6)
    axes.tick_params(labelsize=7)
    axes.set_title("inertial axes, the cone where it is closest", fontsize="small", pad=10)
    handles, labels = axes.get_legend_handles_labels()
    kept = dict(zip(labels, handles, strict=True))
    axes.legend(
        kept.values(),
        kept.keys(),
        frameon=False,
        fontsize=8,
        ncols=3,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.04),
    )


def _cone(axes: Axes, record: PointingRecord, index: int) -> None:
    worst = record.extremes[index]
    step = int(np.argmin(np.abs(record.time - worst.time)))
    d = record.directions[step, index]
    across = np.cross(d, np.eye(3)[np.argmin(np.abs(d))])
    across /= np.linalg.norm(across)
    turn = np.linspace(0.0, 2.0 * np.pi, _RING)[:, None]
    ring = np.cos(worst.allowed) * d + np.sin(worst.allowed) * (
        np.cos(turn) * across + np.sin(turn) * np.cross(d, across)
    )
    _curve(axes, ring, "--", 1, limit_label(worst.kind, worst.name))
    _points(axes, d[None], "*", 1, "direction")


def _on_map(vectors: Floats) -> tuple[Floats, Floats]:
    """Right ascension and declination [rad] of unit vectors (n, 3)."""
    return np.arctan2(vectors[:, 1], vectors[:, 0]), np.arcsin(np.clip(vectors[:, 2], -1.0, 1.0))


def _curve(axes: Axes, vectors: Floats, style: str, index: int, label: str) -> None:
    longitude, latitude = _on_map(vectors)
    # A line must not cross the whole map where it leaves it at one side.
    jumps = np.flatnonzero(np.abs(np.diff(longitude)) > np.pi) + 1
    longitude, latitude = (np.insert(part, jumps, np.nan) for part in (longitude, latitude))
    axes.plot(longitude, latitude, style, color=colour(index), linewidth=1.5, label=label)


def _points(axes: Axes, vectors: Floats, mark: str, index: int, label: str) -> None:
    longitude, latitude = _on_map(vectors)
    axes.plot(longitude, latitude, mark, color=colour(index), linestyle="none", label=label)
