"""Wording of numbers in tables and messages."""

from __future__ import annotations

import math
from collections.abc import Sequence

from jaxatt.records.pointing import Extreme
from jaxatt.simulation.flight_error import FlightError

OBJECTIVES = {
    "l0": "L0",
    "moving-l0": "Moving L0",
    "l1": "L1",
    "time-effort": "Time and effort",
    "minimum-time": "Minimum time",
    "net-power": "Net energy",
}

_SHOWN_RUNS = 12


def objective_title(kind: str) -> str:
    """Title of an objective in tables and figures."""
    return OBJECTIVES.get(kind, kind)


def indices_text(indices: Sequence[int]) -> str:
    """Text of indices as ranges, e.g. "0, 20-23, 49", shortened where there are many."""
    runs: list[list[int]] = []
    for index in indices:
        if runs and index == runs[-1][-1] + 1:
            runs[-1].append(index)
        else:
            runs.append([index])
    texts = []
    for run in runs:
        texts += [f"{run[0]}-{run[-1]}"] if len(run) > 2 else [str(index) for index in run]
    more = len(texts) - _SHOWN_RUNS
    return ", ".join(texts[:_SHOWN_RUNS]) + (f" and {more} more" if more > 0 else "")


LIMITS = {
    "keep-out": ("nearest", "deg"),
    "keep-in": ("farthest", "deg"),
    "body-rate": ("fastest", "deg_s"),
}
"""Kind of a limit on the way -> what its worst instant is called, and its unit in names."""


def limit_label(kind: str, name: str) -> str:
    """Name of a cone or rate limit, e.g. "keep-out sun"."""
    return name if kind == "body-rate" else f"{kind} {name}"


def limit_text(kind: str, value: float, allowed: float, time: float, satisfied: bool) -> str:
    """Text of the closest approach to a limit, e.g. "nearest 34.1 deg, allowed 30 deg"."""
    word, unit = LIMITS[kind]
    unit = unit.replace("_", "/")
    # Enough digits to tell a small violation from none.
    digits = 4 if satisfied else 7
    ends = f"{value:.{digits}g} {unit} at {time:.3g} s, allowed {allowed:.4g} {unit}"
    return f"{word} {ends}"


def broken_limit(extreme: Extreme) -> str:
    """Sentence on a limit that a flight breaks."""
    e = extreme
    text = limit_text(e.kind, math.degrees(e.value), math.degrees(e.allowed), e.time, e.satisfied)
    return f"{limit_label(e.kind, e.name)} is broken: {text}"


def short(value: float | None, digits: int = 4) -> str:
    """Text of a number with few digits; empty for None."""
    return "" if value is None else f"{value:.{digits}g}"


def plural(count: int, word: str) -> str:
    """Text of a count with its noun, e.g. "1 start", "2 starts"."""
    return f"{count} {word}{'' if count == 1 else 's'}"


def uncertain_flight(error: FlightError) -> str:
    """Sentence on a flight that more steps still change by more than a tenth of the tolerances."""
    off = "it is no number"
    if math.isfinite(error.attitude) and math.isfinite(error.rate):
        off = (
            f"half as many change it by {math.degrees(error.attitude):.3g} deg and "
            f"{error.rate:.3g} rad/s"
        )
    return (
        f"the flight itself is uncertain: with {error.steps} Runge-Kutta steps an interval, {off}; "
        "take shorter intervals"
    )
