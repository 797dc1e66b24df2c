"""Read the law that a net-power manoeuvre is compared with."""

from __future__ import annotations

from typing import Any

from jaxatt.problems.net_power.baseline import PDBaseline
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.fields import Table
from jaxatt.spacecraft import Spacecraft


def read_baseline(data: Any, origin: str, craft: Spacecraft) -> PDBaseline | None:
    """Read [baseline], the PD law to compare with; None where there is none."""
    if data is None:
        return None
    table = Table(data, origin, "[baseline]", NET_POWER_TABLES["baseline"])
    if not craft.wheels.count:
        table.fail(next(iter(table.data), "attitude_gain_Nm"), "it needs wheels", "drop [baseline]")
    return PDBaseline(
        proportional=table.number("attitude_gain_Nm"),
        derivative=table.number("rate_gain_Nm_s"),
        hold=table.number("hold_s") if "hold_s" in table else None,
        turn_back=table.number("turn_back_s"),
        nearest_to=table.choice("nearest_to"),
    )
