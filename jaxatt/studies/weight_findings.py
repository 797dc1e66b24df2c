"""Sentences on manoeuvres for many weights of time beside printed ones."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np

_SAME = 1e-5
"""Relative difference of costs, times and energies up to which two are the same."""


class Weighed(Protocol):
    """Figures of a manoeuvre for one weight of time, as `WeightRow` has them."""

    @property
    def time_weight(self) -> float: ...
    @property
    def net_J(self) -> float: ...
    @property
    def final_time_s(self) -> float: ...
    @property
    def cost(self) -> float: ...


def weight_findings(
    rows: Sequence[Weighed],
    printed: Sequence[Weighed],
    claimed: Sequence[float],
    intervals: int,
) -> tuple[str, ...]:
    """Sentences on printed rows that others beat, on what is found, and on what was claimed.

    claimed : [J], net energy of each row by the solver's own count.
    intervals : of each manoeuvre.
    """
    longest = max(row.final_time_s for row in printed) / intervals
    found = [
        *_among(printed, "By their own cost the printed rows are not all best"),
        f"The printed energies come of one integration step an interval, up to {longest:.0f} s "
        "long; nothing is printed of flights with finer steps.",
        *_against(rows, printed),
        _monotone(rows),
        *_among(rows, "Of those found not all are best"),
        _agreement(rows, claimed),
    ]
    return tuple(found)


def better_rows(rows: Sequence[Weighed]) -> list[int]:
    """For each weight the index of the row that is best by the cost with that weight."""
    weight, time, cost = (
        np.array([getattr(row, name) for row in rows])
        for name in ("time_weight", "final_time_s", "cost")
    )
    # Another row's cost with this row's weight differs by the time alone.
    mixed = (cost - weight * time)[None] + weight[:, None] * time[None]
    own = np.arange(len(rows))
    best = mixed.argmin(axis=1)
    gains = mixed[own, own] - mixed[own, best] > _SAME * np.abs(cost)
    return [int(index) for index in np.where(gains, best, own)]


def _among(rows: Sequence[Weighed], words: str) -> list[str]:
    """Sentence on rows that another one beats with their own weight."""
    beaten: dict[int, list[str]] = {}
    for index, best in enumerate(better_rows(rows)):
        if best != index:
            beaten.setdefault(best, []).append(f"{rows[index].time_weight:g}")
    if not beaten:
        return []
    parts = [f"that of {rows[best].time_weight:g} beats {_and(of)}" for best, of in beaten.items()]
    return [f"{words}: of k3, {'; '.join(parts)}."]


def _against(rows: Sequence[Weighed], printed: Sequence[Weighed]) -> list[str]:
    """Sentence on costs below and above the printed ones."""
    below = [p.cost - row.cost for row, p in zip(rows, printed, strict=True) if row.cost < p.cost]
    above = [
        f"{row.time_weight:g}" for row, p in zip(rows, printed, strict=True) if row.cost >= p.cost
    ]
    text = f"The cost found is below the printed one for {len(below)} of {len(rows)} weights"
    if below:
        text += f", by {min(below):.3g} to {max(below):.3g} W"
    return [f"{text}; not for k3 = {_and(above)}." if above else f"{text}."]


def _monotone(rows: Sequence[Weighed]) -> str:
    times = [row.final_time_s for row in rows]
    energies = [row.net_J for row in rows]
    falls = [
        all(b <= a + _SAME * abs(a) for a, b in pairwise(values)) for values in (times, energies)
    ]
    if all(falls):
        return "Time and net energy fall with k3 throughout."
    names = [name for name, ok in zip(("time", "net energy"), falls, strict=True) if not ok]
    return f"Not falling with k3 throughout: {_and(names)}."


def _agreement(rows: Sequence[Weighed], claimed: Sequence[float]) -> str:
    shares = [
        abs(own - row.net_J) / max(np.finfo(float).tiny, abs(row.net_J))
        for row, own in zip(rows, claimed, strict=True)
    ]
    return (
        f"The solver's own count of energy and that of the fine flights differ by "
        f"{100.0 * max(shares):.2g} % at most."
    )


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
