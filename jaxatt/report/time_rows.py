"""Rows of a result's table that only a turn in minimum time has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from jaxatt.records.wording import short

_SHOWN = 6

Row = tuple[str, Callable[[Mapping[str, Any]], str]]


def time_rows(weighted: bool) -> list[Row]:
    """Time, effort, switches and how good the answer is; weighted : whether effort has a price."""
    priced: list[Row] = [("cost [s]", lambda b: short(b["cost"], 8))] if weighted else []
    return [
        ("final time [s]", lambda b: f"{short(b['final_time_s'], 7)}"),
        ("interval [s]", lambda b: short(b["step_s"], 5)),
        ("control effort [(N m)^2 s]", lambda b: short(b["control_effort"], 6)),
        *priced,
        ("with exact switches [s]", _resolved),
        ("switches [s]", lambda b: _switches(b["time_optimum"]["switch_times_s"])),
        ("transcription", _transcription),
        ("optimality", _optimality),
    ]


def _switches(times: Mapping[str, list[float]]) -> str:
    found = [
        f"{name}: {', '.join(short(t) for t in each[:_SHOWN])}{' ...' if each[_SHOWN:] else ''}"
        for name, each in times.items()
        if each
    ]
    return "; ".join(found) or "none from limit to limit"


def _resolved(block: Mapping[str, Any]) -> str:
    found = block["time_optimum"]["resolved_final_time_s"]
    return "" if found is None else short(found, 8)


def _transcription(block: Mapping[str, Any]) -> str:
    used = block["time_optimum"]["transcription"]
    word = {"rk4": "Runge-Kutta", "euler": "forward Euler"}[used["integration"]]
    name = {"mrp": "MRP"}.get(used["attitude"], used["attitude"])
    return f"{name}, {word}; by its own count {short(used['attitude_error_deg'], 3)} deg off"


def _optimality(block: Mapping[str, Any]) -> str:
    kkt, found = block["kkt"], block["time_optimum"]
    share = 100.0 * found["share_at_best"]
    minima = "1 minimum" if found["minima"] == 1 else f"{found['minima']} minima"
    return (
        f"violation {short(kkt['violation'], 2)}, stationarity {short(kkt['stationarity'], 2)}; "
        f"{share:.3g} % of the starts at the best of {minima}"
    )
