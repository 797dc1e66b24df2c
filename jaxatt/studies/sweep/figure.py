"""Figure of a sweep: lines over one quantity, maps of a grid of two, scatter over more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from jaxatt.drawing.figure import Picture, colour, picture, tidy
from jaxatt.runtime.arrays import Floats
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, STATE

if TYPE_CHECKING:
    import xarray

_MOST_PANELS = 30
_AXIS = {"linear": "linear", "logarithmic": "log"}
"""What matplotlib calls the scales of a study."""


def sweep_figure(dataset: xarray.Dataset, names: Sequence[str], outputs: Sequence[str]) -> Picture:
    """Draw every output; samples that do not reach, and those that failed, are marked.

    names : of the swept quantities.
    """
    if dataset.attrs["method"] == "grid" and len(names) == 2:
        return _maps(dataset, names, outputs)
    return _scatter(dataset, names, outputs)


def _maps(dataset: xarray.Dataset, names: Sequence[str], outputs: Sequence[str]) -> Picture:
    """One map an output."""
    columns = min(len(outputs), 3)
    rows = -(-len(outputs) // columns)
    made = picture(4.6 * columns, 3.6 * rows, dataset.attrs["title"])
    panels = made.subplots(rows, columns, squeeze=False)
    for axes, output in zip(panels.flat, outputs, strict=False):
        _map(axes, made, dataset, names, output)
    for axes in panels.flat[len(outputs) :]:
        axes.set_visible(False)
    _legend(made, panels[0, 0])
    return made


def _scatter(dataset: xarray.Dataset, names: Sequence[str], outputs: Sequence[str]) -> Picture:
    """Rows of outputs over columns of quantities, as many as fit into a figure."""
    shown = names[: max(1, _MOST_PANELS // len(outputs))]
    made = picture(3.2 + 3.0 * len(shown), 0.8 + 2.2 * len(outputs), dataset.attrs["title"])
    panels = made.subplots(len(outputs), len(shown), squeeze=False, sharex="col", sharey="row")
    for row, output in zip(panels, outputs, strict=True):
        for axes, name in zip(row, shown, strict=True):
            _points(axes, dataset, name, output, joined=len(names) == 1)
            tidy(axes)
        row[0].set_ylabel(output)
    for axes, name in zip(panels[-1], shown, strict=True):
        axes.set_xlabel(name)
        axes.set_xscale(_AXIS[dataset[name].attrs["spacing"]])
    _legend(made, panels[0, 0])
    return made


def _points(axes: Axes, dataset: xarray.Dataset, name: str, output: str, joined: bool) -> None:
    x, y, state = (dataset[each].values for each in (name, output, STATE))
    reached, failed = state == REACHED, state == FAILED
    if joined:
        order = np.argsort(x)
        order = order[state[order] != 0]
        axes.plot(x[order], np.where(reached, y, np.nan)[order], "-", color=colour(0), lw=1.0)
    axes.plot(x[reached], y[reached], ".", color=colour(0), label="reached")
    missed = (state == NOT_REACHED) & np.isfinite(y)
    if missed.any():
        axes.plot(x[missed], y[missed], "x", color=colour(1), ms=5, label="not reached")
    if failed.any():  # along the lower edge
        edge, low = axes.get_xaxis_transform(), np.full(int(failed.sum()), 0.02)
        axes.plot(x[failed], low, "^", color=colour(3), ms=4, transform=edge, label="no answer")


def _map(
    axes: Axes, made: Picture, dataset: xarray.Dataset, names: Sequence[str], output: str
) -> None:
    state = dataset[STATE].values
    first, second = (dataset[name].values for name in names)
    scales = [dataset[name].attrs["spacing"] for name in names]
    x, y = np.unique(first), np.unique(second)
    field = np.full((len(x), len(y)), np.nan)
    at = np.searchsorted(x, first), np.searchsorted(y, second)
    field[at] = np.where(state == REACHED, dataset[output].values, np.nan)
    axes.set_xscale(_AXIS[scales[0]])
    axes.set_yscale(_AXIS[scales[1]])
    shown = axes.pcolormesh(_edges(x, scales[0]), _edges(y, scales[1]), field.T, cmap="viridis")
    made.colorbar(shown, ax=axes)
    for kind, marker, words in ((NOT_REACHED, "x", "not reached"), (FAILED, "^", "no answer")):
        which = state == kind
        if which.any():
            axes.plot(
                first[which], second[which], marker, color=colour(1), ms=5, ls="none", label=words
            )
    axes.set_xlabel(names[0])
    axes.set_ylabel(names[1])
    axes.set_title(output, fontsize="medium")


def _edges(values: Floats, scale: str) -> Floats:
    """Edges of cells around sorted values, halfway on the scale of the axis."""
    logarithmic = scale == "logarithmic"
    v = np.log(values) if logarithmic else values
    if len(v) == 1:
        edges = np.array([v[0] - 0.5, v[0] + 0.5])
    else:
        middle = 0.5 * (v[1:] + v[:-1])
        edges = np.concatenate([[1.5 * v[0] - 0.5 * v[1]], middle, [1.5 * v[-1] - 0.5 * v[-2]]])
    return np.exp(edges) if logarithmic else edges


def _legend(made: Picture, panel: Axes) -> None:
    """Below the panels, what the marks of one of them mean, where there is more than one kind."""
    handles, labels = panel.get_legend_handles_labels()
    if set(labels) - {"reached"}:
        made.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
