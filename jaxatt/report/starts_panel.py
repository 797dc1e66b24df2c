"""Panel of all starts of a phase: effort against active intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.drawing.figure import colour, no_rounding, tidy, whole_ticks
from jaxatt.records.phase import Phase

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def starts_panel(axes: Axes, phase: Phase, unitless: bool = False) -> None:
    """Mark starts that reached the target, starts that did not, and the answer."""
    starts, unit = phase.starts, 1.0 if unitless else 1e3
    count = np.asarray(starts.active_intervals, float)
    long_way = np.zeros(len(count), bool) if starts.long_way is None else starts.long_way
    # Many starts share a count: side by side they stay visible.
    beside = count + 0.28 * np.sin(2.399963 * np.arange(len(count)))
    for mask, marker, index, words in (
        (~starts.reached, "x", 1, "not reached"),
        (starts.reached & ~long_way, "o", 0, "reached"),
        (starts.reached & long_way, "^", 2, "reached the long way round"),
    ):
        if mask.any():
            label = f"{words} ({int(mask.sum())})"
            style: dict[str, Any] = {"s": 26, "c": colour(index), "marker": marker, "alpha": 0.7}
            axes.scatter(beside[mask], unit * starts.effort[mask], label=label, **style)
    words = "answer" if phase.reached else "answer (does not reach)"
    ringed: dict[str, Any] = {"edgecolor": "black", "zorder": 5}
    answer = ringed | {"s": 170, "c": colour(4), "marker": "*", "label": words}
    axes.scatter(phase.active_intervals, unit * phase.l1_effort, **answer)
    if phase.alternative is not None:
        other, words = phase.alternative, "best that reaches"
        diamond = ringed | {"s": 70, "c": colour(5), "marker": "D", "label": words}
        axes.scatter(other.active_intervals, unit * other.l1_effort, **diamond)
    no_rounding(axes, unit * phase.l1_effort)
    axes.set_xlabel("active intervals")
    axes.set_ylabel("∫ |u| dt" if unitless else "L1 effort [mN m s]")
    whole_ticks(axes.xaxis)
    axes.legend(fontsize=8, frameon=False, loc="best")
    tidy(axes)
