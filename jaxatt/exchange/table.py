"""Write attitudes as a table of numbers separated by commas (CSV)."""

from __future__ import annotations

import numpy as np

from jaxatt.exchange.moments import instants, written
from jaxatt.exchange.motion import AttitudeHistory

COLUMNS = (
    "utc",
    "time_s",
    *(f"q_ib_{part}" for part in "wxyz"),
    *(f"omega_ib_{axis}_rad_s" for axis in "xyz"),
)
"""The attitude turns components in body axes into EME2000, scalar first; rates in body axes."""


def csv_text(history: AttitudeHistory) -> str:
    """Table with one row an instant, under `COLUMNS`."""
    rows = np.column_stack([history.q_ib, history.omega_ib])
    lines = [",".join(COLUMNS)]
    stamps = written(instants(history.epoch, history.time))
    for stamp, time, row in zip(stamps, history.time, rows, strict=True):
        lines.append(f"{stamp}Z,{time:.9f},{','.join(f'{x:.16g}' for x in row)}")
    return "\n".join(lines) + "\n"
