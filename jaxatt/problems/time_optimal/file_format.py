"""Files of turns in minimum time."""

from __future__ import annotations

from jaxatt.problems.reading.file_format import FileFormat
from jaxatt.problems.reading.schema import SPACECRAFT, SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.objective import TIME_KINDS
from jaxatt.problems.time_optimal.reading_parts import read_parts

FORMAT = FileFormat(
    "time-optimal",
    "Turns in minimum time",
    (SPACECRAFT,),
    TIME_KINDS,
    SPACECRAFT_TABLES,
    read_parts,
)
