"""Panels of a turn in free time: MRP, switching times, cost of every start."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from jaxatt.attitude import mrp
from jaxatt.drawing.figure import colour, no_rounding, tidy, whole_ticks
from jaxatt.problems.answer import Answer
from jaxatt.problems.sections import Panel
from jaxatt.problems.time_optimal.record import time_optimum
from jaxatt.records.phase import Phase
from jaxatt.records.timeline import timeline
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_sigma = jax.jit(mrp.from_quaternion)


def panels(answer: Answer, common: Mapping[str, Panel]) -> dict[str, Panel]:
    """Panels of any answer, with the MRP above the Euler angles."""
    chosen: dict[str, Panel] = {}
    for name, panel in common.items():
        if name == "euler_angles":
            chosen["mrp"] = modified_rodrigues
        chosen[name] = panel
    return chosen


def modified_rodrigues(axes: Axes, result: Answer) -> None:
    """Draw the MRP inside the unit sphere with dotted targets; lines break where sets switch."""
    line = timeline(result.phases)
    sigma = np.asarray(_sigma(line.nodes["q_ob"]))
    time, broken = _broken(line.time, sigma)
    for index in range(3):
        label = ("σ₁", "σ₂", "σ₃")[index]
        axes.plot(time, broken[:, index], color=colour(index), linewidth=1.5, label=label)
    for phase in result.phases:
        for index, value in enumerate(np.asarray(_sigma(phase.reference["q_ob"]))):
            style: dict[str, Any] = {"linestyle": "dotted", "linewidth": 1.4}
            axes.axhline(value, color=colour(index), **style)
    axes.set_ylabel("MRP")


def mark_switches(axes: Axes, result: Answer, kind: str, only: int | None = None) -> None:
    """Draw dotted lines where a torque of "wheels" or "thrusters" switches; only : one of them."""
    vehicle = result.scenario.vehicle
    assert vehicle is not None
    count = vehicle.wheels.count
    shown = {"wheels": slice(count), "thrusters": slice(count, None)}.get(kind, slice(0))
    for phase in result.phases:
        for index, times in enumerate(time_optimum(phase).switch_times[shown]):
            if only not in (None, index):
                continue
            for time in times:
                style: dict[str, Any] = {"linestyle": "dotted", "linewidth": 1.0}
                axes.axvline(phase.start_time + time, color=colour(index), **style)


def costs_panel(axes: Axes, phase: Phase) -> None:
    """Draw the cost of every start from the best to the worst, reached or not."""
    optimum, starts = time_optimum(phase), phase.starts
    known = np.isfinite(optimum.start_costs)
    order = np.argsort(np.where(known, optimum.start_costs, np.inf), kind="stable")
    rank, cost, reached = 1 + np.arange(len(order)), optimum.start_costs[order], starts.reached
    for mask, marker, index, words in (
        (~reached[order], "x", 1, "not reached"),
        (reached[order], "o", 0, "reached"),
    ):
        if mask.any():
            style: dict[str, Any] = {"s": 20, "color": colour(index), "marker": marker}
            axes.scatter(rank[mask], cost[mask], label=f"{words} ({int(mask.sum())})", **style)
    axes.axhline(optimum.cost, color="#444444", linewidth=0.8, linestyle=(0, (4, 3)))
    no_rounding(axes, optimum.cost)
    axes.set_xlabel(f"starts in order of cost ({100 * optimum.share:.0f} % at the best)")
    axes.set_ylabel("cost [s]")
    whole_ticks(axes.xaxis)
    axes.legend(fontsize=8, frameon=False, loc="best")
    tidy(axes)


def _broken(time: Floats, sigma: Floats) -> tuple[Floats, Floats]:
    """Time and MRP with a gap wherever the set switches."""
    jumps = 1 + np.flatnonzero(np.linalg.norm(np.diff(sigma, axis=0), axis=1) > 1.0)
    return np.insert(time, jumps, np.nan), np.insert(sigma, jumps, np.nan, axis=0)
