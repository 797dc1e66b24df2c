"""Write attitudes as an attitude file (.a) of STK.

STK's quaternion is the turn of CoordinateAxes into the axes of the body, scalar last; its rate is
in body axes and in degrees.  Its J2000 are the mean equator and equinox of that date: EME2000.
"""

from __future__ import annotations

import datetime as dt

import numpy as np

from jaxatt.exchange.aem import scalar_last
from jaxatt.exchange.motion import AttitudeHistory

_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def stk_text(history: AttitudeHistory) -> str:
    """Attitude file with quaternions and rates."""
    moment = history.epoch.astimezone(dt.UTC)
    date = f"{moment.day} {_MONTHS[moment.month - 1]} {moment.year}"
    lines = [
        "stk.v.11.0",
        "",
        "BEGIN Attitude",
        f"NumberOfAttitudePoints {len(history.time)}",
        f"ScenarioEpoch {date} {moment:%H:%M:%S}.{moment.microsecond:06d}",
        "BlockingFactor 20",
        "InterpolationOrder 1",
        "CentralBody Earth",
        "CoordinateAxes J2000",
        "",
        "AttitudeTimeQuatAngVels",
        "",
    ]
    rows = np.column_stack([scalar_last(history.q_ib), np.degrees(history.omega_ib)])
    for time, row in zip(history.time, rows, strict=True):
        lines.append(f"{time:.9f} " + " ".join(f"{x: .15e}" for x in row))
    return "\n".join([*lines, "", "END Attitude"]) + "\n"
