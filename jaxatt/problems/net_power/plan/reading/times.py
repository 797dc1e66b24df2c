"""Read when a task begins and ends: in seconds since the epoch, or by the clock."""

from __future__ import annotations

import datetime as dt
import math
from typing import NoReturn

from jaxatt.environment.epoch import J2000, SECONDS_PER_DAY, parse
from jaxatt.problems.net_power.plan.reading.schema import LONGEST_MANOEUVRE_S
from jaxatt.problems.reading.fields import Table

_CLOCK = 'write a time of day in UTC such as "09:31:11", or a date with it'


def read_span(table: Table, before: float, days: float | None) -> tuple[float, float]:
    """Read start and end [s] of a task.

    before : [s], end of the task before, where this one begins unless it says otherwise.
    days : epoch, days since J2000; None without, and then there is no clock.
    """
    start = before
    if "start" in table:
        start = _clock(table, "start", before, days, after=False)
    elif "start_s" in table:
        start = table.number("start_s")
    if "end" in table:
        end = _clock(table, "end", start, days, after=True)
    elif "end_s" in table:
        end = table.number("end_s")
    else:
        end = start + table.number("duration_s")
    key = "end" if "end" in table else "end_s"
    if not end > start:
        table.fail(key, f"is not after the task's start at {start:g} s", "give a later end")
    if end - start > LONGEST_MANOEUVRE_S:
        key = "duration_s" if "duration_s" in table else key
        table.fail(
            key,
            f"the task takes {end - start:g} s, more than {LONGEST_MANOEUVRE_S:g}",
            "end it earlier, or divide it into several",
        )
    return start, end


def _clock(table: Table, key: str, near: float, days: float | None, *, after: bool) -> float:
    """Seconds since the epoch of an instant by the clock.

    A time of day stands for the instant nearest to `near`, or for the first one after it.
    """
    text = table.text(key)
    if days is None:
        table.fail(key, "is a time by the clock, but the plan has no epoch", "add [orbit] epoch")
    epoch = J2000 + dt.timedelta(days=days)
    try:
        moment = dt.time.fromisoformat(text)
    except ValueError:
        try:
            date = parse(text)
        except ValueError:
            _no_clock(table, key)
        return _rounded((date - epoch).total_seconds())
    seconds = moment.hour * 3600 + moment.minute * 60 + moment.second + moment.microsecond * 1e-6
    midnight = epoch.replace(hour=0, minute=0, second=0, microsecond=0)
    at = _rounded(seconds - (epoch - midnight).total_seconds())
    away = (at - near) / SECONDS_PER_DAY
    turns = math.ceil(away) - 1 if after else round(away)
    return at - turns * SECONDS_PER_DAY


def _rounded(seconds: float) -> float:
    """Seconds without the rounding of an epoch that is kept in days."""
    return round(seconds, 4)


def _no_clock(table: Table, key: str) -> NoReturn:
    table.fail(key, "is no time by the clock", _CLOCK)
