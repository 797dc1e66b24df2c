"""Figure of a sweep: lines over one quantity, maps of a grid of two, scatter over more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.runtime.arrays import Floats
from jaxatt.studies.sweep.study import FAILED, NOT_REACHED, REACHED, SCENARIO, STATE

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

    from jaxatt.drawing.picture import Picture

_MOST_PANELS = 30
_MOST_TICKS = 7
"""Values of a quantity that all stand at its axis."""
_AXIS = {"linear": "linear", "logarithmic": "log"}
"""What matplotlib calls the scales of a study."""


def sweep_figure(
    dataset: xarray.Dataset,
    names: Sequence[str],
    outputs: Sequence[str],
    against: Sequence[str] = (),
) -> Picture:
    """Draw every output; samples that do not reach, and those that failed, are marked.

    names : of the swept quantities.  against : outputs that the others are drawn over, too.
    """
    groups, names = _by_scenario(dataset), [name for name in names if name != SCENARIO]
    if dataset.attrs["method"] == "grid" and len(names) == 2 and not against:
        return _maps(dataset.attrs["title"], groups, names, outputs)
    return _scatter(dataset.attrs["title"], groups, [*names, *against], outputs)


def _by_scenario(dataset: xarray.Dataset) -> dict[str, xarray.Dataset]:
    """The samples of each scenario by its name, or all under no name."""
    if SCENARIO not in dataset:
        return {"": dataset}
    of = dataset[SCENARIO].values
    return {str(name): dataset.isel(sample=of == name) for name in dict.fromkeys(of.tolist())}


def _maps(
    title: str,
    groups: Mapping[str, xarray.Dataset],
    names: Sequence[str],
    outputs: Sequence[str],
) -> Picture:
    """One map a scenario and output."""
    panels = [(name, group, output) for name, group in groups.items() for output in outputs]
    columns = len(outputs) if len(groups) > 1 else min(len(outputs), 3)
    rows = -(-len(panels) // columns)
    made = picture(4.6 * columns, 3.6 * rows, title)
    axes = made.subplots(rows, columns, squeeze=False)
    for panel, (name, group, output) in zip(axes.flat, panels, strict=False):
        _map(panel, made, group, names, output)
        panel.set_title(f"{name}: {output}" if name else output, fontsize="medium")
    for panel in axes.flat[len(panels) :]:
        panel.set_visible(False)
    _legend(made, axes[0, 0])
    return made


def _scatter(
    title: str,
    groups: Mapping[str, xarray.Dataset],
    names: Sequence[str],
    outputs: Sequence[str],
) -> Picture:
    """Rows of outputs over columns of quantities, as many as fit into a figure."""
    shown = names[: max(1, _MOST_PANELS // len(outputs))]
    made = picture(3.2 + 3.0 * len(shown), 0.8 + 2.2 * len(outputs), title)
    panels = made.subplots(len(outputs), len(shown), squeeze=False, sharex="col", sharey="row")
    first = next(iter(groups.values()))
    joined = sum(name not in outputs for name in names) == 1
    for row, output in zip(panels, outputs, strict=True):
        for axes, name in zip(row, shown, strict=True):
            if name == output:
                axes.set_visible(False)
                continue
            for number, (scenario, group) in enumerate(groups.items()):
                _points(axes, group, name, output, joined, number, scenario or "reached")
            tidy(axes)
        row[0].set_ylabel(output.replace(".", "\n"))
    for axes, name in zip(panels[-1], shown, strict=True):
        axes.set_xlabel(name)
        axes.set_xscale(_AXIS[first[name].attrs.get("spacing", "linear")])
    _legend(made, panels[0, 0])
    return made


def _points(
    axes: Axes,
    dataset: xarray.Dataset,
    name: str,
    output: str,
    joined: bool,
    number: int,
    label: str,
) -> None:
    """Draw the samples of one scenario, the one of this number."""
    x, y, state = (dataset[each].values for each in (name, output, STATE))
    reached, failed = state == REACHED, state == FAILED
    if joined:
        order = np.argsort(x)
        order = order[state[order] != 0]
        axes.plot(x[order], np.where(reached, y, np.nan)[order], "-", color=colour(number), lw=1.0)
    axes.plot(x[reached], y[reached], ".", color=colour(number), label=label)
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
    for axis, values in ((axes.xaxis, x), (axes.yaxis, y)):
        if len(values) <= _MOST_TICKS:  # cells reach beyond the values that were solved
            axis.set_ticks(values, labels=[f"{value:.4g}" for value in values])
            axis.set_ticks([], minor=True)
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
    of = dict(zip(*panel.get_legend_handles_labels()[::-1], strict=True))
    if set(of) - {"reached"}:
        made.legend(
            list(of.values()),
            list(of),
            loc="outside lower center",
            ncols=3,
            frameon=False,
            fontsize=8,
        )
