"""Instants in UTC as the files of other tools write them, to the nanosecond."""

from __future__ import annotations

import datetime as dt
import re
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from jaxatt.environment.epoch import parse
from jaxatt.runtime.arrays import Floats

Instants: TypeAlias = npt.NDArray[np.datetime64]
"""Instants in UTC in whole nanoseconds; every day has 86400 s."""

_FRACTION = re.compile(r"\.(\d+)")
_DAY_OF_YEAR = re.compile(r"^(\d{4})-(\d{3})(?=T)")


def instants(epoch: dt.datetime, seconds: Floats) -> Instants:
    """Instants (n,) so many seconds (n,) after an epoch."""
    offset = np.rint(1e9 * seconds).astype("timedelta64[ns]")
    return np.asarray(np.datetime64(epoch.astimezone(dt.UTC).replace(tzinfo=None), "ns") + offset)


def seconds_after(first: np.datetime64, moments: Instants) -> Floats:
    """Seconds (n,) from a first instant to others (n,)."""
    return np.asarray((moments - first) / np.timedelta64(1, "ns") * 1e-9)


def written(moments: Instants) -> list[str]:
    """Calendar dates with times, such as 2026-06-21T12:00:00.000000000."""
    return [str(text) for text in np.datetime_as_string(moments, unit="ns")]


def short(moment: np.datetime64) -> str:
    """An instant for messages, to the millisecond."""
    return f"{np.datetime_as_string(moment, unit='ms')}Z"


def read(text: str) -> np.datetime64:
    """Instant of a calendar date or of a day of the year with a time, UTC.

    Raises `ValueError` where the text is neither.
    """
    found = _FRACTION.search(text)
    digits = found.group(1) if found else ""
    whole = _FRACTION.sub("", text, count=1)
    day = _DAY_OF_YEAR.match(whole)
    if day is not None:
        first = dt.date(int(day.group(1)), 1, 1) + dt.timedelta(days=int(day.group(2)) - 1)
        if first.year != int(day.group(1)):
            raise ValueError(f"{text} is no moment")
        whole = f"{first.isoformat()}{whole[day.end() :]}"
    if "T" not in whole:
        raise ValueError(f"{text} is no moment")
    moment = parse(whole)
    return np.datetime64(moment.replace(tzinfo=None), "ns") + np.timedelta64(
        int(digits[:9].ljust(9, "0") or 0), "ns"
    )
