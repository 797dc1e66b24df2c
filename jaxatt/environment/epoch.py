"""Calendar time: days since J2000, decimal years and the Earth's rotation angle."""

from __future__ import annotations

import datetime as dt
import math
import re

import jax
import jax.numpy as jnp

J2000 = dt.datetime(2000, 1, 1, 12, tzinfo=dt.UTC)
SECONDS_PER_DAY = 86400.0
DAYS_PER_CENTURY = 36525.0
EARTH_RATE = 7.292115146706979e-5
"""Rate of the Earth's rotation [rad/s]."""
TERRESTRIAL_TIME_AHEAD = 69.184
"""Terrestrial Time less UTC since 2017 [s]."""


_LEAP_SECOND = re.compile(r"(?<=:\d\d):60(?=\.|,|Z|z|[+-]|$)")
NO_LEAP_SECOND = "only the last second of a day in UTC can be a leap second"


def parse(text: str) -> dt.datetime:
    """Read an instant such as 2020-03-20T12:00:00Z; without a time zone it is taken as UTC.

    A leap second is taken for the first second of the next day: UTC stands for UT1 throughout.
    Raises `ValueError` where the text is no moment.
    """
    early, leap = _LEAP_SECOND.subn(":59", text)
    moment = dt.datetime.fromisoformat(early)
    moment = moment.replace(tzinfo=dt.UTC) if moment.tzinfo is None else moment.astimezone(dt.UTC)
    if not leap:
        return moment
    if (moment.hour, moment.minute) != (23, 59):
        raise ValueError(NO_LEAP_SECOND)
    return moment + dt.timedelta(seconds=1)


def days_since_j2000(moment: dt.datetime) -> float:
    """Days since J2000, with UTC taken for UT1 (less than a second apart)."""
    return (moment - J2000).total_seconds() / SECONDS_PER_DAY


def moment_text(days: float) -> str:
    """Moment of some days since J2000 as text, to the second, such as 2026-06-21T12:00:00Z."""
    moment = J2000 + dt.timedelta(days=days, seconds=0.5)
    return f"{moment:%Y-%m-%dT%H:%M:%SZ}"


def terrestrial(days: jax.Array) -> jax.Array:
    """Days (...) of Terrestrial Time since J2000, by which planets move; days (...) in UTC.

    With the leap seconds of 2017: within 12 s since 1990, in which the sun moves 0.0002 deg.
    """
    return days + TERRESTRIAL_TIME_AHEAD / SECONDS_PER_DAY


def decimal_year(moment: dt.datetime) -> float:
    """Year with the elapsed fraction of it, e.g. 2020.5."""
    first = dt.datetime(moment.year, 1, 1, tzinfo=dt.UTC)
    length = dt.datetime(moment.year + 1, 1, 1, tzinfo=dt.UTC) - first
    return moment.year + (moment - first) / length


def rotation_angle(days: jax.Array) -> jax.Array:
    """Earth rotation angle [rad]; `days` since J2000, any shape.

    The IERS conventions (2010), eq. (5.15).  It counts from an origin that does not follow the
    equinox; `precession.earth_fixed` has the axes.
    """
    whole = jnp.floor(days)
    turns = 0.7790572732640 + 0.00273781191135448 * days + (days - whole)
    return 2.0 * math.pi * (turns - jnp.floor(turns))
