"""The report in Markdown: throughputs, the other side, and the ratios against the goals."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

_MAIN = "hypso1-90-45-15"


def markdown(report: Mapping[str, Any]) -> str:
    """All tables of a report."""
    parts = [_machine(report), _own(report), _others(report), _ratios(report)]
    return "\n\n".join(part for part in parts if part)


def grid(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table with a heading."""
    names = list(head)
    lines = ["| " + " | ".join(names) + " |", "|" + " --- |" * len(names)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _machine(report: Mapping[str, Any]) -> str:
    m = report["machine"]
    return (
        f"{m['date']}; {m['processor']}, {m['cores']} cores; device {m['device']}; jax {m['jax']}, "
        f"jaxatt {m['jaxatt']}; fused float64 peak {report['peak_flops'] / 1e9:.0f} GF/s."
    )


def _own(report: Mapping[str, Any]) -> str:
    rows = [
        (
            row["what"],
            str(row["batch"]),
            f"{row['compile_s']:.1f}",
            f"{1e3 * row['run_s']:.2f}",
            f"{row['per_second']:.0f}",
            _percent(row["useful_share"]),
            _percent(row["peak_share"]),
        )
        for row in report["jaxatt"]
    ]
    head = ("jaxatt", "batch", "compile [s]", "run [ms]", "a second", "useful", "of peak")
    return grid(head, rows)


def _others(report: Mapping[str, Any]) -> str:
    rows = [
        (
            f"{side['method']}, {side['case']}",
            str(side["starts"]),
            f"{side['build_s']:.0f}",
            f"{1e3 * side['run_s']:.0f}",
            f"{side['cpu_ms_a_start']:.1f}",
            f"{side['useful']}",
            f"{side['useful_per_second']:.1f}",
            f"{side['memory_MiB']:.0f}",
        )
        for side in report["casadi"]
    ]
    head = (
        *("CasADi", "starts", "build [s]", "run [ms]", "CPU a start [ms]", "useful"),
        *("useful a second", "memory [MiB]"),
    )
    return grid(head, rows)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100.0 * share:.0f} %"


def _useful_rate(report: Mapping[str, Any], what: str, batch: int | None = None) -> float | None:
    for row in report["jaxatt"]:
        if row["what"] == what and (batch is None or row["batch"] == batch):
            return float(row["per_second"] * row["useful_share"])
    return None


def _other_rate(report: Mapping[str, Any], method: str, case: str) -> float | None:
    for side in report["casadi"]:
        if (side["method"], side["case"]) == (method, case):
            return float(side["useful_per_second"])
    return None


def _in_turn(turns: Sequence[Mapping[str, Any]]) -> list[tuple[str, str, str]]:
    """Medians, and the range, of ratios whose sides were measured straight after each other."""

    def row(name: str, ratios: list[float], digits: int, goal: str) -> tuple[str, str, str]:
        middle, least, most = statistics.median(ratios), min(ratios), max(ratios)
        return name, f"{middle:.{digits}f} ({least:.{digits}f} to {most:.{digits}f})", goal

    if not turns:
        return []
    rows = [
        row(
            f"in turn, useful a second against IPOPT, {batch} starts, times",
            [turn["jaxatt"][batch] / turn["ipopt"] for turn in turns],
            0,
            "100" if batch == "64" else "",
        )
        for batch in turns[0]["jaxatt"]
    ]
    shares = [turn["jaxatt"]["1024"] / max(turn["jaxatt"].values()) for turn in turns]
    return [*rows, row("in turn, 1024 starts, of the best batch", shares, 2, "0.9")]


def _ratios(report: Mapping[str, Any]) -> str:
    rows: list[tuple[str, str, str]] = []

    def ratio(name: str, own: float | None, other: float | None, goal: str) -> None:
        if own is None or other is None:
            return
        shown = f"{own / other:.0f} times" if other > 0.0 else "no useful start on the other side"
        rows.append((name, shown, goal))

    own = _useful_rate(report, f"search, {_MAIN}", 64)
    riccati = _useful_rate(report, f"search, riccati, {_MAIN}")
    ratio("useful a second against IPOPT", own, _other_rate(report, "ipopt", _MAIN), "100 times")
    ratio("the same against FATROP", own, _other_rate(report, "fatrop", _MAIN), "")
    for chain in ("thesis-chain", "thesis-chain-warm"):
        ratio(f"the same against {chain}", own, _other_rate(report, chain, _MAIN), "2000 times")
    ratio("Riccati path against IPOPT", riccati, _other_rate(report, "ipopt", _MAIN), "10 times")
    for row in report["jaxatt"]:
        if row["useful_share"] is not None:
            goal = {
                f"search, {_MAIN}": "95 %",
                f"search, {_MAIN}-half-torque": "80 %",
                "search and polish, double-integrator": "80 %",
            }
            rows.append(
                (
                    f"useful share, {row['what']}, {row['batch']} starts",
                    _percent(row["useful_share"]),
                    goal.get(row["what"], ""),
                )
            )
    shares = [row["peak_share"] for row in report["jaxatt"] if row["peak_share"] is not None]
    rows.append(("roll-outs, share of the fused peak", _percent(max(shares)), "30 %"))
    rates = {
        row["batch"]: row["per_second"]
        for row in report["jaxatt"]
        if row["what"] == f"search, {_MAIN}"
    }
    if 1024 in rates:
        share = rates[1024] / max(rates.values())
        rows.append(("starts a second at 1024 starts, of the best batch", f"{share:.2f}", "0.9"))
    rows += _in_turn(report.get("turns", ()))
    found = report["certificate"]
    for way in ("short", "long"):
        name = f"all {found['pairs']} pairs, the {way} way round ({found[f'{way}_reach']} reach)"
        rows.append((name, f"{found[f'{way}_s']:.2f} s", "0.3 s"))
    if "processes" in report:
        cold, cached = report["processes"]["cold"], report["processes"]["cached"]
        rows += [
            ("compile, cold", f"{cold['compile_s']:.1f} s", "8 s"),
            ("compile, from the cache", f"{cached['compile_s']:.1f} s", "2 s"),
            (f"jaxatt solve {_MAIN}, cold process", f"{cold['wall_s']:.1f} s", "20 s"),
            ("the same from the cache", f"{cached['wall_s']:.1f} s", ""),
            ("its memory", f"{cold['memory_MiB']:.0f} MiB", ""),
        ]
    return grid(("what", "found", "goal"), rows)
