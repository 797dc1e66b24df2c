"""Figure of a sweep: lines over one quantity, maps of a grid of two, scatter over more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from jaxatt.drawing.figure import Picture, colour, picture, tidy
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, STATE

if TYPE_CHECKING:
    import xarray

_LOGARITHMIC = 20.0
"""Ratio of greatest to least value from which an axis is logarithmic."""

_MOST_PANELS = 30


def sweep_figure(dataset: xarray.Dataset, names: Sequence[str], outputs: Sequence[str]) -> Picture:
    """Draw every output; samples that do not reach, and those that failed, are marked."""
    state = dataset[STATE].values
    values = {name: dataset[name].values for name in (*names, *outputs)}
    title = dataset.attrs["title"]
    if dataset.attrs["method"] == "grid" and len(names) == 2:
        made, first = _maps(values, names, outputs, state, title)
    else:
        made, first = _scatter(values, names, outputs, state, title)
    handles, labels = first.get_legend_handles_labels()
    if set(labels) - {"reached"}:
        made.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    return made


def _maps(
    values: Mapping[str, Floats],
    names: Sequence[str],
    outputs: Sequence[str],
    state: Any,
    title: str,
) -> tuple[Picture, Axes]:
    """One map an output; the first panel, too, which has all marks."""
    columns = min(len(outputs), 3)
    rows = -(-len(outputs) // columns)
    made = picture(4.6 * columns, 3.6 * rows, title)
    panels = made.subplots(rows, columns, squeeze=False)
    for axes, output in zip(panels.flat, outputs, strict=False):
        _map(axes, made, values, names, output, state)
    for axes in panels.flat[len(outputs) :]:
        axes.set_visible(False)
    return made, panels[0, 0]


def _scatter(
    values: Mapping[str, Floats],
    names: Sequence[str],
    outputs: Sequence[str],
    state: Any,
    title: str,
) -> tuple[Picture, Axes]:
    """Rows of outputs over columns of quantities, as many as fit; the first panel, too."""
    shown = names[: max(1, _MOST_PANELS // len(outputs))]
    made = picture(3.2 + 3.0 * len(shown), 0.8 + 2.2 * len(outputs), title)
    panels = made.subplots(len(outputs), len(shown), squeeze=False, sharex="col", sharey="row")
    for row, output in zip(panels, outputs, strict=True):
        for axes, name in zip(row, shown, strict=True):
            _points(axes, values[name], values[output], state, joined=len(names) == 1)
            tidy(axes)
        row[0].set_ylabel(output)
    for axes, name in zip(panels[-1], shown, strict=True):
        axes.set_xlabel(name)
        _scale(axes, "x", values[name])
    return made, panels[0, 0]


def _points(axes: Axes, x: Floats, y: Floats, state: Any, joined: bool) -> None:
    reached = state == REACHED
    if joined:
        order = np.argsort(x)
        order = order[state[order] != 0]
        axes.plot(x[order], np.where(reached, y, np.nan)[order], "-", color=colour(0), lw=1.0)
    axes.plot(x[reached], y[reached], ".", color=colour(0), label="reached")
    missed = (state == NOT_REACHED) & np.isfinite(y)
    if missed.any():
        axes.plot(x[missed], y[missed], "x", color=colour(1), ms=5, label="not reached")
    _along_the_edge(axes, x, state == FAILED)


def _along_the_edge(axes: Axes, x: Floats, failed: Flags) -> None:
    """Mark samples without an answer at the lower edge."""
    if failed.any():
        axes.plot(
            x[failed],
            np.full(int(failed.sum()), 0.02),
            "^",
            color=colour(3),
            ms=4,
            transform=axes.get_xaxis_transform(),
            label="no answer",
        )


def _map(
    axes: Axes,
    made: Picture,
    values: Mapping[str, Floats],
    names: Sequence[str],
    output: str,
    state: Any,
) -> None:
    x, y = (np.unique(values[name]) for name in names)
    at = np.searchsorted(x, values[names[0]]), np.searchsorted(y, values[names[1]])
    field = np.full((len(x), len(y)), np.nan)
    field[at] = np.where(state == REACHED, values[output], np.nan)
    for which, name in enumerate(names):
        _scale(axes, "xy"[which], values[name])
    shown = axes.pcolormesh(_edges(x), _edges(y), field.T, cmap="viridis")
    made.colorbar(shown, ax=axes)
    for kind, marker, words in ((NOT_REACHED, "x", "not reached"), (FAILED, "^", "no answer")):
        which_ones = state == kind
        if which_ones.any():
            points = (values[name][which_ones] for name in names)
            axes.plot(*points, marker, color=colour(1), ms=5, ls="none", label=words)
    axes.set_xlabel(names[0])
    axes.set_ylabel(names[1])
    axes.set_title(output, fontsize="medium")


def _edges(values: Floats) -> Floats:
    """Edges of cells around sorted values, halfway on the scale of the axis."""
    logarithmic = _is_logarithmic(values)
    v = np.log(values) if logarithmic else values
    if len(v) == 1:
        edges = np.array([v[0] - 0.5, v[0] + 0.5])
    else:
        middle = 0.5 * (v[1:] + v[:-1])
        edges = np.concatenate([[1.5 * v[0] - 0.5 * v[1]], middle, [1.5 * v[-1] - 0.5 * v[-2]]])
    return np.exp(edges) if logarithmic else edges


def _scale(axes: Axes, which: str, values: Floats) -> None:
    if _is_logarithmic(values):
        (axes.set_xscale if which == "x" else axes.set_yscale)("log")


def _is_logarithmic(values: Floats) -> bool:
    return bool(values.min() > 0.0 and values.max() >= _LOGARITHMIC * values.min())
