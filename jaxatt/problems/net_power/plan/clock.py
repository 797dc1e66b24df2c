"""Times of a plan as people read them."""

from __future__ import annotations

import datetime as dt

from jaxatt.environment.epoch import J2000


def clock_text(time: float, days: float | None) -> str:
    """Text of an instant [s] since the epoch, for messages and tables: by the clock if there is
    one."""
    if days is None:
        return f"{time:g} s"
    moment = J2000 + dt.timedelta(days=days) + dt.timedelta(seconds=time)
    rounded = (moment + dt.timedelta(milliseconds=500)).replace(microsecond=0)
    return f"{rounded:%H:%M:%S}"
