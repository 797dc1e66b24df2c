"""Read and check a free final time of a scenario with sparse control."""

from __future__ import annotations

import math
from typing import NoReturn

from jaxatt.problems.reading.fields import Table


def nearest_whole(value: float) -> int:
    """Return the nearest whole number, halves upward (Python's round takes the even one)."""
    return math.floor(value + 0.5)


def read_final_time(table: Table, default: str = "fixed") -> tuple[bool, float, float]:
    """Read from [horizon] whether the final time is free, and its shortest and longest [s]."""
    free = table.choice("final_time", default) == "free"
    for key in ("shortest_s", "longest_s"):
        if key in table and not free:
            table.fail(
                key, "the final time is fixed", 'add final_time = "free", or keep horizon_s alone'
            )
    shortest = table.number("shortest_s")
    longest = table.number("longest_s", math.inf)
    if shortest > longest:
        table.fail("shortest_s", f"more than longest_s = {longest:g}", "exchange the two")
    return free, shortest, longest


def refuse_seconds(table: Table, key: str, instead: str) -> NoReturn:
    """Refuse a time in seconds where the intervals have no length yet."""
    table.fail(
        key,
        "the final time is free, so the intervals have no length yet",
        f"give {instead}, which move with the final time",
    )
