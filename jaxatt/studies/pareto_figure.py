"""Figure of a Pareto front: gain over cost, and what a unit of cost gains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.problems.front import Front
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture


def front_figure(front: Front, price: Floats, title: str) -> Picture:
    """Draw a front with its dominated points and what stands beside; price : (K,)."""
    figure = picture(9.0, 4.2, title)
    left, right = figure.subplots(1, 2)
    order = np.argsort(front.costs)
    costs, gains = front.costs[order], front.gains[order]
    best, reached = front.best[order], front.reached[order]
    left.plot(costs[best], gains[best], "o-", color=colour(0), markersize=4, label="front")
    other = reached & ~best
    if other.any():
        left.plot(
            costs[other], gains[other], "o", color=colour(0), mfc="none", ms=6, label="dominated"
        )
    beside = front.reference
    if beside is not None:
        line = "s--" if len(beside.costs) > 1 else "s"
        left.plot(
            beside.costs, beside.gains, line, color=colour(1), markersize=4, label=beside.name
        )
    left.set_ylabel(front.gain.label)
    left.legend(frameon=False, fontsize=8)
    known = np.isfinite(price[order])
    right.plot(costs[known], price[order][known], "o-", color=colour(2), markersize=4)
    right.set_ylabel(f"price [{front.gain.unit}/{front.cost.unit}]")
    for axes in (left, right):
        _finish(axes, front)
    right.set_xlim(left.get_xlim())
    # From zero: a price that hardly changes is to look so.
    right.set_ylim(0.0, 1.1 * price[order][known].max(initial=0.0) or 1.0)
    return figure


def _finish(axes: Axes, front: Front) -> None:
    axes.set_xlabel(front.cost.label)
    if front.cost.logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    tidy(axes)
