"""Tables of energies and of errors at the end beside printed values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.records.wording import short


def energy_table(
    title: str, rows: Sequence[Mapping[str, Any]], printed: Mapping[str, Mapping[str, float]]
) -> tuple[Table, Table]:
    """Tables of energies and of errors at the end, the printed values in brackets.

    rows : as `jaxatt.studies.energy_comparison.EnergyRow`, with "gain_J".
    printed : label of a row -> "net_J", "baseline_J", "quaternion_error", "rate_error" and
    "baseline_...", where the source has them.
    """
    earned = _table(title, ("net [J]", "PD law [J]", "gain [J]", "gain [%]", "at the best"))
    ended = _table(
        "Errors at the end, flown again",
        ("attitude [deg]", "1 - |q'q_ref|", "of the PD law", "rate^2 [rad2/s2]", "of the PD law"),
    )
    for row in rows:
        style = "" if row["reached"] else "bold red"
        head = Text(row["label"], style=style)
        beside = printed.get(row["label"], {})
        base, gain = row["baseline_J"], row["gain_J"]
        compared = base is not None and row["mode"] == "harvest"
        both = "net_J" in beside and "baseline_J" in beside
        earned.add_row(
            head,
            _beside(f"{row['net_J']:.1f}", beside.get("net_J")),
            _beside(f"{base:.1f}", beside.get("baseline_J")) if compared else "",
            _beside(
                f"{gain:+.1f}",
                f"{beside['net_J'] - beside['baseline_J']:+.1f}" if both else None,
            )
            if compared
            else "",
            f"{100.0 * gain / base:+.2f}" if compared and base > 0.0 else "",
            f"{100.0 * row['share_at_best']:.0f} %" if compared else "",
        )
        if row["quaternion_error"] is None:
            continue
        ended.add_row(
            head,
            short(row["attitude_error_deg"], 3),
            *(
                _beside(short(row[name], 3), beside.get(name))
                for name in (
                    "quaternion_error",
                    "baseline_quaternion_error",
                    "rate_error",
                    "baseline_rate_error",
                )
            ),
        )
    return earned, ended


def _table(title: str, headers: Sequence[str]) -> Table:
    table = Table(
        title=Text(title, style="bold"),
        box=box.SIMPLE_HEAD,
        title_justify="left",
        padding=(0, 1, 0, 0),
        pad_edge=False,
    )
    table.add_column("", no_wrap=True)
    for header in headers:
        table.add_column(Text(header), justify="right")
    return table


def _beside(ours: str, printed: Any) -> str:
    return ours if printed is None else f"{ours} ({printed})"
