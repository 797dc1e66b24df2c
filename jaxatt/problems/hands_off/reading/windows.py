"""Read windows of intervals that are cheap or forbidden."""

from __future__ import annotations

from typing import Any

from jaxatt.problems.hands_off.windows import interval_mask
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.free_time import nearest_whole, refuse_seconds
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.scenario_parts import Horizon, Window

# A time on the edge of the horizon must not be refused for the rounding of its last digit.
_TIME_TOLERANCE = 1e-9


def read_windows(data: Any, origin: str, horizon: Horizon) -> tuple[Window, ...]:
    """Read and check the windows of the [[windows]] tables."""
    if not isinstance(data, list):
        raise ScenarioError(
            f"{origin}: windows: must be a list of tables; write [[windows]] with double brackets"
        )
    faults = Faults()
    windows = [
        faults.of(_window, item, origin, f"[[windows]] no. {index + 1}", horizon)
        for index, item in enumerate(data)
    ]
    faults.refuse()
    blocked = interval_mask(tuple(w for w in windows if w.forbidden), horizon.intervals)
    if blocked.all():
        raise ScenarioError(
            f"{origin}: [[windows]] forbid torque in all {horizon.intervals} intervals; "
            "leave at least one interval free"
        )
    return tuple(windows)


def _window(data: Any, origin: str, label: str, horizon: Horizon) -> Window:
    table = Table(data, origin, label, SPACECRAFT_TABLES["windows"])
    first, last = _range(table, horizon)
    forbidden = table.flag("forbidden")
    if forbidden and "weight" in table:
        table.fail("weight", "given for a forbidden window", "drop weight or forbidden")
    weight = 1.0 if forbidden else table.number("weight")
    return Window(first, last, weight, forbidden)


def _range(table: Table, horizon: Horizon) -> tuple[int, int]:
    by_index = "first_interval" in table or "last_interval" in table
    by_time = "start_s" in table or "end_s" in table
    if by_index and by_time:
        key = "start_s" if "start_s" in table else "end_s"
        table.fail(key, "given beside interval numbers", "give intervals or times, not both")
    if by_time:
        if horizon.free:
            key = "start_s" if "start_s" in table else "end_s"
            refuse_seconds(table, key, "first_interval = ... and last_interval = ...")
        return _range_by_time(table, horizon)
    first = table.integer("first_interval")
    last = table.integer("last_interval")
    count = horizon.intervals
    for key, value in (("first_interval", first), ("last_interval", last)):
        if value >= count:
            table.fail(
                key,
                f"outside the horizon of {count} intervals",
                f"allowed: 0 to {count - 1} (zero-based, both ends included)",
            )
    if first > last:
        table.fail("last_interval", f"before first_interval = {first}", "exchange the two")
    return first, last


def _range_by_time(table: Table, horizon: Horizon) -> tuple[int, int]:
    start = table.number("start_s")
    end = table.number("end_s")
    for key, value in (("start_s", start), ("end_s", end)):
        if not -_TIME_TOLERANCE <= value <= horizon.duration + _TIME_TOLERANCE:
            table.fail(
                key,
                f"outside the horizon of {horizon.duration:g} s",
                f"allowed: 0 to {horizon.duration:g} seconds",
            )
    if start > end:
        table.fail("end_s", f"before start_s = {start:g}", "exchange the two")
    last_index = horizon.intervals - 1
    first = min(nearest_whole(start / horizon.step), last_index)
    return first, min(nearest_whole(end / horizon.step), last_index)
