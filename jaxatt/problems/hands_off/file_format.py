"""Files of sparse manoeuvres."""

from __future__ import annotations

from jaxatt.problems.hands_off.reading.parts import read_parts
from jaxatt.problems.reading.file_format import FileFormat
from jaxatt.problems.reading.schema import SPACECRAFT, SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.objective import SPARSE_KINDS

FORMAT = FileFormat(
    "hands-off", "Sparse manoeuvres", (SPACECRAFT,), SPARSE_KINDS, SPACECRAFT_TABLES, read_parts
)
