"""Files of manoeuvres and plans that earn energy."""

from __future__ import annotations

from jaxatt.problems.net_power.reading.parts import read_parts
from jaxatt.problems.net_power.reading.tables import KIND, NET_POWER_TABLES
from jaxatt.problems.reading.file_format import FileFormat
from jaxatt.problems.reading.schema import SPACECRAFT

FORMAT = FileFormat(
    "net-power",
    "Manoeuvres and plans that earn energy",
    (SPACECRAFT,),
    (KIND,),
    NET_POWER_TABLES,
    read_parts,
)
