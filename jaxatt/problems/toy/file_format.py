"""Files of the toy systems."""

from __future__ import annotations

from jaxatt.problems.reading.file_format import FileFormat
from jaxatt.problems.reading.tables.objective import SPARSE_KINDS
from jaxatt.problems.toy.reading_parts import read_parts
from jaxatt.problems.toy.tables import TOY_TABLES

FORMAT = FileFormat(
    "toy", "Toy systems", ("double-integrator", "van-der-pol"), SPARSE_KINDS, TOY_TABLES, read_parts
)
