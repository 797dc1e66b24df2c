"""Numbers in words, for tables and messages."""

from __future__ import annotations

from collections.abc import Sequence

OBJECTIVES = {
    "l0": "L0",
    "moving-l0": "Moving L0",
    "l1": "L1",
    "time-effort": "Time and effort",
    "minimum-time": "Minimum time",
}

_SHOWN_RUNS = 12


def indices_text(indices: Sequence[int]) -> str:
    """Indices as ranges, e.g. "0, 20-23, 49", cut short where there are many."""
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


def short(value: float | None, digits: int = 4) -> str:
    """A number with few digits; empty where there is none."""
    return "" if value is None else f"{value:.{digits}g}"


def plural(count: int, word: str) -> str:
    """A count with its noun, e.g. "1 start", "2 starts"."""
    return f"{count} {word}{'' if count == 1 else 's'}"
