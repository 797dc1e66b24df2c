"""Tables of energies and of errors at the end beside printed values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from jaxatt.records.wording import short


def energy_table(
    title: str,
    rows: Sequence[Mapping[str, Any]],
    printed: Mapping[str, Mapping[str, float]],
    totals: Sequence[tuple[Mapping[str, Any], Mapping[str, float]]] = (),
) -> tuple[Table, Table]:
    """Tables of energies and of errors at the end, the printed values in brackets.

    rows : as `jaxatt.studies.energy_comparison.EnergyRow`, with "gain_J".
    printed : label of a row -> "net_J", "baseline_J", "quaternion_error", "rate_error" and
    "baseline_...", where the source has them.
    totals : each as `Total`, with the printed values beside it.
    """
    earned = _table(title, ("net [J]", "PD law [J]", "gain [J]", "gain [%]", "at the best"))
    ended = _table(
        "Errors at the end, flown again",
        ("off [deg]", "1 - |q'q_ref|", "PD law", "rate^2 [rad2/s2]", "PD law"),
    )
    for row in rows:
        style = "" if row["reached"] else "bold red"
        head = Text(row["label"], style=style)
        beside = printed.get(row["label"], {})
        compared = row["baseline_J"] is not None and row["mode"] == "harvest"
        energies = _energies(row, beside) if compared else [f"{row['net_J']:.1f}", "", "", ""]
        earned.add_row(head, *energies, f"{100.0 * row['share_at_best']:.0f} %" if compared else "")
        if row["quaternion_error"] is None:
            continue
        ended.add_row(
            head,
            short(row["attitude_error_deg"], 2),
            *(
                _beside(short(row[name], 2), short(beside.get(name), 2) or None)
                for name in (
                    "quaternion_error",
                    "baseline_quaternion_error",
                    "rate_error",
                    "baseline_rate_error",
                )
            ),
        )
    earned.add_section()
    for total, beside in totals:
        if total["baseline_J"] is not None:
            earned.add_row(total["label"], *_energies(total, beside), "")
    return earned, ended


def _energies(row: Mapping[str, Any], beside: Mapping[str, float]) -> list[str]:
    """Cells of net energy, the PD law's and the gain."""
    net, base = row["net_J"], row["baseline_J"]
    asked, law = beside.get("net_J"), beside.get("baseline_J")
    both = asked is not None and law is not None
    return [
        _beside(f"{net:.1f}", asked),
        _beside(f"{base:.1f}", law),
        _beside(f"{net - base:+.1f}", f"{asked - law:+.1f}" if both else None),
        _beside(_percent(net, base), _percent(asked, law) if both else None),
    ]


def _percent(net: float, base: float) -> str:
    """Gain as a share of a baseline; of one that loses, a share says nothing."""
    return f"{100.0 * (net / base - 1.0):+.3g}" if base > 0.0 else "-"


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
