"""Table, figures and rows of a plan over the dates of a year."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.dates import ConciseDateFormatter
from rich.text import Text

from jaxatt.drawing.figure import colour, picture, tidy
from jaxatt.problems.reading.dates import moment_of
from jaxatt.records.dense_table import dense_table
from jaxatt.runtime.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from rich.table import Table

    from jaxatt.drawing.picture import Picture

Row = Mapping[str, Any]
"""A date, under the names of the files; None where a number is not known."""

_SHOWN = 26
"""Rows of the table in the terminal, and lines on dates that fail; the file has all dates."""
_COLUMNS = {
    "beta_deg": "beta\n[deg]",
    "net_J": "all tasks\n[J]",
    "harvests_J": "harvests\n[J]",
    "baseline_J": "PD law\n[J]",
    "gain_J": "gain\n[J]",
    "gain_percent": "gain\n[%]",
    "least_charge_percent": "least\ncharge [%]",
}
_FAILED = "#D55E00"


def year_table(title: str, rows: Sequence[Row], last_line: str) -> Table:
    """Table of some dates, evenly apart, and below it all that fail, with the reason."""
    count = len(rows)
    picked = sorted({round(k) for k in np.linspace(0, count - 1, min(_SHOWN, count))})
    table = dense_table(
        f"{title}: {count} {'date' if count == 1 else 'dates'}",
        Text("\n".join(_caption(rows, len(picked) < count, last_line))),
    )
    table.add_column("date", no_wrap=True)
    for name in _COLUMNS.values():
        table.add_column(Text(name), justify="right", no_wrap=True)
    for k in picked:
        cells = ["" if rows[k][key] is None else f"{rows[k][key]:.1f}" for key in _COLUMNS]
        table.add_row(rows[k]["date"], *cells)
    return table


def _caption(rows: Sequence[Row], some: bool, last_line: str) -> list[str]:
    lines = ["Some of the dates; year.csv has all."] if some else []
    gains = [row["gain_J"] for row in rows if row["gain_J"] is not None]
    if gains:
        lines.append(
            f"Gain over the PD law: {min(gains):.1f} to {max(gains):.1f} J, mean "
            f"{np.mean(gains):.1f} J."
        )
    failed = [f"{row['date']}: {row['reason']}" for row in rows if not row["reached"]]
    told = "The plan can be flown on all dates."
    if failed:
        told = f"{len(failed)} of {len(rows)} dates cannot be flown:"
    shown = failed if len(failed) <= _SHOWN else failed[: _SHOWN - 1]
    if len(shown) < len(failed):
        shown.append(f"and {len(failed) - len(shown)} more, with their reasons in year.csv")
    return [*lines, told, *shown, last_line]


def year_figure(title: str, rows: Sequence[Row], days: Floats) -> Picture:
    """Draw energies, gain, least charge and the sun's height over the date.

    days : (D,), of the rows, since J2000.  Dates that cannot be flown are marked.
    """
    dates = [moment_of(day) for day in days]
    stored = any(row["least_charge_percent"] is not None for row in rows)
    figure = picture(9.0, 8.6 if stored else 6.8, title)
    column = figure.subplots(4 if stored else 3, 1, sharex=True)
    style: dict[str, Any] = {"linewidth": 1.5, "marker": "." if len(rows) < 60 else ""}
    for key, index, words in (("harvests_J", 0, "plan"), ("baseline_J", 1, "PD law")):
        values = 1e-3 * _values(rows, key)
        column[0].plot(dates, values, color=colour(index), label=words, **style)
    column[0].set_ylabel("harvests [kJ]")
    column[0].legend(
        frameon=False, fontsize=8, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2
    )
    column[1].plot(dates, _values(rows, "gain_J"), color=colour(2), **style)
    column[1].set_ylabel("gain [J]")
    if stored:
        column[2].plot(dates, _values(rows, "least_charge_percent"), color=colour(3), **style)
        column[2].set_ylabel("least charge [%]")
    column[-1].plot(dates, _values(rows, "beta_deg"), color=colour(6), **style)
    column[-1].set_ylabel("beta angle [deg]")
    concise: Any = ConciseDateFormatter
    time = column[-1].xaxis
    time.set_major_formatter(concise(time.get_major_locator()))
    for axes in column:
        tidy(axes)
        for date, row in zip(dates, rows, strict=True):
            if not row["reached"]:
                axes.axvline(date, color=_FAILED, linewidth=0.8, alpha=0.6)
    figure.align_ylabels(column)
    return figure


def beta_figure(title: str, rows: Sequence[Row], days: Floats) -> Picture:
    """Draw the gain and the harvests' energy against the sun's height above the orbit's plane.

    Every height is passed on the way up and on the way down, which differ by the sun's direction
    along the orbit: the colour tells the day of the year.
    """
    figure = picture(9.0, 4.6, title)
    row = figure.subplots(1, 2, sharex=True)
    seasons = np.array([moment_of(day).timetuple().tm_yday for day in days])
    found = [_over_beta(row[0], rows, "harvests_J", 1e-3, seasons, "harvests [kJ]")]
    found.append(_over_beta(row[1], rows, "gain_J", 1.0, seasons, "gain [J]"))
    figure.colorbar(found[-1], ax=row, label="day of the year")
    return figure


def _over_beta(
    axes: Axes, rows: Sequence[Row], key: str, unit: float, seasons: Floats, label: str
) -> Any:
    values = unit * _values(rows, key)
    points = axes.scatter(
        _values(rows, "beta_deg"), values, c=seasons, cmap="twilight", vmin=1, vmax=366, s=14
    )
    axes.set_xlabel("beta angle [deg]")
    axes.set_ylabel(label)
    tidy(axes)
    return points


def _values(rows: Sequence[Row], key: str) -> Floats:
    return np.array([np.nan if row[key] is None else row[key] for row in rows], float)
