"""Tables and figure of manoeuvres for many weights of time beside printed values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table
from rich.text import Text

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.records.dense_table import dense_table
from jaxatt.records.wording import short
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from jaxatt.drawing.picture import Picture


_Rows = Sequence[Mapping[str, Any]]


def weight_table(title: str, rows: _Rows, printed: _Rows) -> tuple[Table, Table]:
    """Tables of what is earned and of the errors at the end, the printed values in brackets.

    rows, printed : as `jaxatt.studies.weight_comparison.WeightRow.to_dict`; the first also with
    "attitude_error_deg", "claimed_J" and "reached".
    """
    earned = _table(title, ("net [J]", "time T [s]", "mean power [W]", "cost (6.2a) [W]"))
    ended = _table(
        "At the end, flown again",
        ("off [deg]", "1 - |q'q_ref|", "rate^2 [rad2/s2]", "claimed - flown [J]"),
    )
    for row, beside in zip(rows, printed, strict=True):
        head = Text(f"{row['time_weight']:g}", style="" if row["reached"] else "yellow")
        earned.add_row(
            head,
            _beside(row, beside, "net_J", ".1f", ".0f"),
            _beside(row, beside, "final_time_s", ".1f", ".0f"),
            _beside(row, beside, "mean_power_W", ".3f", ".3f"),
            _beside(row, beside, "cost", ".3f", ".3f"),
        )
        ended.add_row(
            head,
            short(row["attitude_error_deg"], 2),
            _beside(row, beside, "quaternion_error", ".1e", ".1e"),
            _beside(row, beside, "rate_error", ".1e", ".1e"),
            f"{row['claimed_J'] - row['net_J']:+.2g}",
        )
    return earned, ended


def weight_figure(title: str, rows: _Rows, printed: _Rows) -> Picture:
    """Figure of net energy over time; each point carries the exponent of its weight."""
    figure = picture(9.0, 5.5, f"{title}\nnumbers: exponent of the weight of time k3")
    axes = figure.subplots()
    for of, words, index, marker, place in (
        (printed, "printed", 1, "x", (5, -12)),
        (rows, "found, flown again", 0, "o", (6, 3)),
    ):
        time, energy = (np.array([row[name] for row in of]) for name in ("final_time_s", "net_J"))
        axes.plot(time, energy, marker, color=colour(index), linestyle="", label=words)
        exponents = np.log10([row["time_weight"] for row in of])
        for first, last in _alike(time, energy):
            text = f"{exponents[first]:.3g}"
            if last > first:
                text += f" to {exponents[last]:.3g}"
            style: dict[str, Any] = {"color": colour(index), "fontsize": 8}
            where = (time[first], energy[first])
            axes.annotate(text, where, xytext=place, textcoords="offset points", **style)
    axes.margins(0.08)
    axes.set_xlabel("final time [s]")
    axes.set_ylabel("net energy [J]")
    axes.legend(frameon=False, loc="upper left")
    tidy(axes)
    return figure


def _alike(time: Floats, energy: Floats) -> list[tuple[int, int]]:
    """First and last index of every run of points that the figure cannot tell apart."""
    points = np.stack([time, energy], axis=1)
    shares = np.abs(np.diff(points, axis=0)) / np.maximum(np.ptp(points, axis=0), 1e-300)
    apart = np.flatnonzero((shares > 0.01).any(axis=1))
    starts, ends = [0, *(apart + 1)], [*apart, len(time) - 1]
    return [(int(first), int(last)) for first, last in zip(starts, ends, strict=True)]


def _table(title: str, headers: Sequence[str]) -> Table:
    table = dense_table(title)
    table.add_column("k3 [W/s]", no_wrap=True)
    for header in headers:
        table.add_column(Text(header), justify="right")
    return table


def _beside(
    row: Mapping[str, Any], beside: Mapping[str, Any], name: str, ours: str, printed: str
) -> str:
    return f"{row[name]:{ours}} ({beside[name]:{printed}})"
