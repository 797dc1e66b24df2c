"""Table of turns in free time beside printed values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.records.dense_table import dense_table
from jaxatt.records.wording import short

_WORDS = {"euler": "forward Euler", "rk4": "Runge-Kutta"}


def time_table(title: str, rows: Sequence[Mapping[str, Any]], printed: Mapping[str, Any]) -> Group:
    """Table of obtained values with the printed ones in brackets, then the optimality.

    rows : as `jaxatt.studies.time_comparison.TimeRow`.
    printed : "final_time_s", "final_time_below_s" and "step_s", where the source has them.
    """
    most = printed.get("final_time_below_s")
    time = printed.get("final_time_s", None if most is None else f"< {most:g}")
    step = printed.get("step_s")
    found = _table(title, ("final time [s]", "interval [s]", "effort [(N m)^2 s]", "cost [s]"))
    judged = _table(
        "Flown again",
        ("off [deg]", "at the best", "minima", "violation", "stationarity", "time [s]"),
    )
    for row in rows:
        style = "" if row["reached"] else "yellow"
        turn = f"{row['angle_rad']:.4g} rad"
        head = (Text(turn, style=style), Text(_WORDS[row["integration"]], style=style))
        found.add_row(
            *head,
            _beside(f"{row['final_time_s']:.4f}", time),
            _beside(f"{row['step_s']:.4f}", step),
            short(row["control_effort"]),
            f"{row['cost_s']:.4f}",
        )
        judged.add_row(
            *head,
            short(row["attitude_error_deg"], 3),
            f"{100 * row['share_at_best']:.3g} % of {row['starts']}",
            str(row["minima"]),
            short(row["violation"], 2),
            short(row["stationarity"], 2),
            short(row["time_s"], 3),
        )
    return Group(found, judged)


def _table(title: str, headers: Sequence[str]) -> Table:
    table = dense_table(title)
    table.add_column("turn", no_wrap=True)
    table.add_column("transcription", no_wrap=True)
    for header in headers:
        table.add_column(Text(header), justify="right")
    return table


def _beside(ours: str, printed: Any) -> str:
    return ours if printed is None else f"{ours} ({printed})"
