"""Table of several controllers on one scenario, printed values beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from jaxatt.records.dense_table import dense_table
from jaxatt.records.wording import indices_text, short


def comparison_table(
    title: str,
    rows: Sequence[Mapping[str, Any]],
    printed: Mapping[str, Any] | None = None,
    findings: Sequence[str] = (),
) -> Group:
    """Table of obtained and printed values, followed by the quality of the answers.

    rows : as `jaxatt.studies.comparison.Row.to_dict` gives them.
    printed : the scenario's printed values.
    findings : sentences below the tables.
    """
    toy = all(row["state_error"] is not None for row in rows)
    errors: tuple[str, ...] = ("attitude [deg]", "rate [rad/s]")
    if toy:
        errors = ("state error", "in tolerance")
    passing = any(row["waypoint_error_deg"] is not None for row in rows)
    errors += ("waypoint [deg]",) if passing else ()
    timed = len({row["final_time_s"] for row in rows}) > 1
    errors += ("final time [s]",) if timed else ()
    sparsity = any(row["printed"]["relative_sparsity_percent"] is not None for row in rows)
    found = _controllers(
        (
            "active (printed)",
            *(("% of all (printed)",) if sparsity else ()),
            "intervals",
            "outside windows (printed)",
            "weighted",
            "optimised in",
        ),
        title,
    )
    judged = _controllers(
        (*errors, "L1 effort", "J", "starts reached", "time [s] (printed)"), "Flown again"
    )
    for row in rows:
        name = Text(row["controller"], style="" if row["reached"] else "yellow")
        found.add_row(
            name,
            _beside(row["active_intervals"], row["printed"]["active_intervals"]),
            *([_share(row)] if sparsity else []),
            indices_text(row["active_interval_indices"]),
            _beside(row["active_outside_windows"], row["printed"]["active_outside_windows"]),
            short(row["weighted_active_intervals"]),
            row["axes"],
        )
        worst = [short(row["state_error"], 3), "yes" if row["reached"] else "no"]
        if not toy:
            worst = [short(row["attitude_error_deg"], 3), short(row["rate_error_rad_s"], 3)]
        if passing:
            worst.append(short(row["waypoint_error_deg"], 3))
        if timed:
            worst.append(short(row["final_time_s"]))
        judged.add_row(
            name,
            *worst,
            short(row["l1_effort_Nms"]),
            short(row["objective_total"]),
            "" if row["starts"] is None else f"{row['starts_reached']} of {row['starts']}",
            _beside(short(row["time_s"], 3), short(row["printed"]["cpu_time_s"], 4)),
        )
    told = [Text(sentence) for sentence in findings]
    return Group(found, judged, *([_printed(printed)] if sparsity and printed else []), *told)


def _share(row: Mapping[str, Any]) -> str:
    printed = row["printed"]["relative_sparsity_percent"]
    return _beside(short(row["relative_sparsity_percent"]), short(printed))


def _printed(printed: Mapping[str, Any]) -> Text:
    """Text of what the source prints besides counts."""
    values = {
        name: value
        for block in printed.values()
        if isinstance(block, Mapping)
        for name, value in block.items()
    }
    listed = ", ".join(f"{name} {value}" for name, value in values.items())
    return Text(f"Printed in table {printed.get('table', '?')}: {listed}.")


def _controllers(headers: Sequence[str], title: str) -> Table:
    table = dense_table(title)
    table.add_column("controller", no_wrap=True)
    for header in headers:
        table.add_column(Text(header), justify="left" if header == "intervals" else "right")
    return table


def _beside(ours: Any, printed: Any) -> str:
    mine = "-" if ours is None or ours == "" else str(ours)
    return mine if printed is None or printed == "" else f"{mine} ({printed})"
