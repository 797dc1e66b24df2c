"""Read and check a free final time of a scenario with sparse control."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NoReturn

from jaxatt.problems.scenario import SPARSE_KINDS, Horizon, Objective
from jaxatt.scenarios.fields import Table


def read_final_time(table: Table, default: str = "fixed") -> tuple[bool, float, float]:
    """Read from [horizon] whether the final time is free, and its shortest and longest [s]."""
    free = table.choice("final_time", ("fixed", "free"), default) == "free"
    for key in ("shortest_s", "longest_s"):
        if key in table and not free:
            table.fail(
                key, "the final time is fixed", 'add final_time = "free", or keep horizon_s alone'
            )
    shortest = table.number("shortest_s", 0.0, at_least=0.0)
    longest = table.number("longest_s", math.inf, above=0.0)
    if shortest > longest:
        table.fail("shortest_s", f"more than longest_s = {longest:g}", "exchange the two")
    return free, shortest, longest


def check_free_time(
    document: Mapping[str, Any], origin: str, horizon: Horizon, objective: Objective
) -> None:
    """Refuse a free final time without a longest value, and a price on a fixed final time.

    Raises `ScenarioError`.
    """
    if objective.kind not in SPARSE_KINDS:
        return
    if horizon.free and not math.isfinite(horizon.longest):
        table = Table(document["horizon"], origin, "[horizon]", tuple(document["horizon"]))
        table.fail(
            "longest_s",
            "missing",
            f"a free final time of kind = {objective.kind} needs the longest allowed, in seconds",
        )
    if objective.time_weight > 0.0 and not horizon.free:
        table = Table(document["objective"], origin, "[objective]", tuple(document["objective"]))
        table.fail(
            "time_weight_1_s",
            "the final time is fixed, so its price changes nothing",
            'add [horizon] final_time = "free" and longest_s, or drop it',
        )


def refuse_seconds(table: Table, key: str, instead: str) -> NoReturn:
    """Refuse a time in seconds where the intervals have no length yet."""
    table.fail(
        key,
        "the final time is free, so the intervals have no length yet",
        f"give {instead}, which move with the final time",
    )
