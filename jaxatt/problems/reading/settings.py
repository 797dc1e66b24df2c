"""Read horizon and disturbances of a scenario."""

from __future__ import annotations

import math
from typing import Any

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.free_time import read_final_time
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.manoeuvre import MOST_STEPS
from jaxatt.problems.scenario_parts import Disturbances, Horizon

_LARGEST_PHASE = 1000.0
"""[rad] of a sinusoidal torque in a control interval."""


def read_substeps(table: Table, intervals: int = 1) -> int | None:
    """Read the Runge-Kutta steps of an interval; None where they are chosen automatically."""
    if "substeps" not in table:
        return None
    found, most = table.integer("substeps"), MOST_STEPS // intervals
    if found > most:
        table.fail("substeps", f"must be at most {most}", "give a smaller whole number")
    return found


def read_horizon(data: Any, origin: str) -> Horizon:
    """Read the horizon: its length, fixed or free within limits, and its intervals."""
    table = Table(data, origin, "[horizon]", SPACECRAFT_TABLES["horizon"])
    free, shortest, longest = read_final_time(table)
    default = longest if math.isfinite(longest) else None
    duration = table.number("horizon_s", default)
    if not shortest <= duration <= longest:
        table.fail(
            "horizon_s",
            f"outside the final times allowed, {shortest:g} to {longest:g} seconds",
            "drop it, or change shortest_s or longest_s",
        )
    intervals = table.integer("intervals")
    coast = table.integer("coast_intervals")
    return Horizon(
        duration=duration,
        intervals=intervals,
        coast_intervals=coast,
        substeps=read_substeps(table, intervals + coast),
        free=free,
        shortest=shortest,
        longest=longest,
    )


def read_disturbances(data: Any, origin: str, horizon: Horizon) -> Disturbances:
    """Read the disturbances; a negative sine amplitude is a phase of half a turn."""
    table = Table(data, origin, "[disturbances]", SPACECRAFT_TABLES["disturbances"])
    torque = table.number("sinusoidal_torque_Nm")
    frequency = table.number("sinusoidal_frequency_rad_s")
    step = (horizon.longest if horizon.free else horizon.duration) / horizon.intervals
    if torque and frequency * step > _LARGEST_PHASE:
        table.fail(
            "sinusoidal_frequency_rad_s",
            f"is {frequency * step:.3g} rad in a control interval of {step:g} s, more than steps "
            "can follow",
            "give a lower frequency or more intervals, or leave the torque out",
        )
    return Disturbances(table.flag("gravity_gradient"), torque, frequency)
