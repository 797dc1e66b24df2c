"""Tables of energies and of errors at the end beside printed values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from jaxatt.records.dense_table import dense_table
from jaxatt.records.wording import short

# In the order of table 5.8.
_ERRORS = ("quaternion_error", "baseline_quaternion_error", "rate_error", "baseline_rate_error")


def energy_table(
    title: str,
    rows: Sequence[Mapping[str, Any]],
    printed: Mapping[str, Mapping[str, float]],
    totals: Sequence[tuple[Mapping[str, Any], Mapping[str, float]]] = (),
) -> tuple[Table, Table]:
    """Tables of energies and of errors at the end, each value before the printed one.

    rows : as `jaxatt.studies.energy_comparison.EnergyRow`, with "gain_J".
    printed : label of a row -> "net_J", "baseline_J", "quaternion_error", "rate_error" and
    "baseline_...", where the source has them.
    totals : each as `Total`, with the printed values beside it.
    """
    earned = _table(title, ("net [J]", "PD law", "gain [J]", "[%]"))
    ended = _table(
        "At the end, flown again: q = 1 - |q' q_ref|, w = squared rate error [rad2/s2]",
        ("q", "PD law", "w", "PD law"),
        ("off [deg]",),
    )
    for row in rows:
        head = Text(row["label"], style="" if row["reached"] else "bold red")
        beside = printed.get(row["label"], {})
        if row["mode"] != "harvest" or row["baseline_J"] is None:
            earned.add_row(head, f"{row['net_J']:.1f}")
            continue
        earned.add_row(head, *_energies(row, beside))
        if row["quaternion_error"] is None:
            continue
        ended.add_row(
            head,
            short(row["attitude_error_deg"], 2),
            *(
                cell
                for name in _ERRORS
                for cell in (_power_of_ten(row[name]), _printed(_power_of_ten(beside.get(name))))
            ),
        )
    earned.add_section()
    for total, beside in totals:
        if total["baseline_J"] is not None:
            earned.add_row(total["label"], *_energies(total, beside))
    return earned, ended


def _energies(row: Mapping[str, Any], beside: Mapping[str, float]) -> list[str | Text]:
    """Cells of net energy, the PD law's, the gain and its share, each before the printed one."""
    ours = _account(row["net_J"], row["baseline_J"])
    asked, law = beside.get("net_J"), beside.get("baseline_J")
    theirs = [""] * len(ours) if asked is None or law is None else _account(asked, law)
    return [cell for a, b in zip(ours, theirs, strict=True) for cell in (a, _printed(b))]


def _account(net: float, base: float) -> list[str]:
    # Of a law that loses energy a share says nothing.
    share = f"{100.0 * (net / base - 1.0):+.3g}" if base > 0.0 else "-"
    return [f"{net:.1f}", f"{base:.1f}", f"{net - base:+.1f}", share]


def _power_of_ten(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"


def _printed(text: str) -> Text:
    return Text(text, style="dim")


def _table(title: str, headers: Sequence[str], alone: Sequence[str] = ()) -> Table:
    """Empty table; headers : with a column for printed values behind each.  alone : without."""
    table = dense_table(title)
    table.add_column("", no_wrap=True)
    for header in alone:
        table.add_column(Text(header), justify="right", no_wrap=True)
    for header in headers:
        table.add_column(Text(header), justify="right", no_wrap=True)
        table.add_column(Text("printed", style="dim"), justify="right", no_wrap=True)
    return table
