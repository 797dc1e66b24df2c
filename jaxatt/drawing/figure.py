"""Figures without global state, in colours that colour-blind readers can tell apart."""

from __future__ import annotations

import math
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from jaxatt.runtime.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

    from jaxatt.drawing.picture import Picture

# Okabe and Ito (2008), ordered so that neighbours differ in brightness too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
CHEAP, FORBIDDEN, COAST = "#F0E442", "#666666", "#DDDDDD"
_LETTERS = 9.5
"""Letters of a title that fit into an inch."""


def picture(width: float, height: float, title: str = "") -> Picture:
    """Make an empty figure of a size in inches."""
    from jaxatt.drawing.picture import Picture  # matplotlib is loaded by whoever draws

    figure = Picture(width, height)
    if title:
        across = round(_LETTERS * width)
        figure.suptitle("\n".join(fill(line, across) for line in title.splitlines()))
    return figure


def colour(index: int) -> str:
    """Colour of the line with this number."""
    return COLOURS[index % len(COLOURS)]


def tidy(axes: Axes) -> None:
    """Give axes a light grid and no box."""
    axes.grid(True, color="#E6E6E6", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def whole_ticks(axis: Axis) -> None:
    """Put ticks at whole numbers only."""
    from matplotlib.ticker import MaxNLocator

    axis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def no_rounding(axes: Axes, value: float) -> None:
    """Widen the vertical axis to 0.1 % around a value, where rounding alone would fill it."""
    if math.isfinite(value):
        (low, high), reach = axes.get_ylim(), 1e-3 * abs(value)
        axes.set_ylim(min(low, value - reach), max(high, value + reach))


def save(figure: Picture, path: str | Path) -> None:
    """Write a figure as PNG, completely or not at all."""
    with replacing(path) as partial:
        figure.write_png(partial)
