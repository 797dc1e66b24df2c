"""Read the speeds that wheels avoid, and those that a scenario gives to wheels that are mounted."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.vehicle import AVOID_KEYS
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.parts.speed_bands import speed_bands
from jaxatt.spacecraft.parts.wheels import ReactionWheels

_NAMES = {
    "slowest": "from_rad_s",
    "fastest": "to_rad_s",
    "longest_stay": "leave_within_s",
}


def read_avoid(wheels: Table, count: int) -> list[tuple[Any, Any, Any]]:
    """Read the [[vehicle.wheels.avoid]] tables of `count` wheels, as `speed_bands` takes them."""
    given = wheels.data.get("avoid", [])
    if not isinstance(given, list):
        wheels.fail(
            "avoid",
            "must be a list of tables",
            "write [[vehicle.wheels.avoid]] with double brackets",
        )
    return [
        _band(data, f"[[vehicle.wheels.avoid]] no. {number}", wheels.origin, count)
        for number, data in enumerate(given, 1)
    ]


def _band(data: Any, label: str, origin: str, count: int) -> tuple[Any, Any, Any]:
    table = Table(data, origin, label, AVOID_KEYS)
    stay = table.number("leave_within_s", 0.0)
    slowest, fastest = table.data.get("from_rad_s", 0.0), table.require("to_rad_s")
    band = slowest, fastest, stay
    try:
        speed_bands([band], count)
    except FieldError as error:
        problem, mend = error.problem_and_mend
        if "at least 0" in mend or "must be" in mend:
            mend = f"{mend}: bands are of the magnitude, so that one around zero is from 0"
        table.fail(_NAMES[error.field], problem, mend)
    return band


def read_wheel_speeds(
    table: Table, wheels: ReactionWheels, key: str = "wheel_speed_rad_s"
) -> Floats:
    """Read the speeds (n,) [rad/s] of the wheels that work, zero without the key.

    The list has one entry for each wheel that is mounted; a failed one stands still.
    """
    every = len(wheels.mounted_names)
    speeds = table.vector(key, every, np.zeros(every))
    for place in set(range(every)) - set(wheels.working):
        if speeds[place] != 0.0:
            name = wheels.mounted_names[place]
            table.fail(
                key,
                f"{name} has failed, and a failed wheel stands still in the body",
                f"give 0 for {name}, or take it out of [vehicle.wheels] failed",
            )
    kept: Floats = speeds[list(wheels.working)]
    check_speeds(table, kept, wheels, key)
    return kept


def read_initial_speeds(data: Any, origin: str, wheels: ReactionWheels) -> Floats:
    """Read the speeds (n,) [rad/s] with which the wheels that work begin, from [initial]."""
    table = Table(data, origin, "[initial]", SPACECRAFT_TABLES["initial"])
    return read_wheel_speeds(table, wheels)


def check_speeds(
    table: Table, speeds: Floats, wheels: ReactionWheels, key: str = "wheel_speed_rad_s"
) -> None:
    """Refuse speeds (n,) [rad/s] of the wheels that work which they must not have."""
    limits = np.asarray(wheels.speed_limit)
    if (np.abs(speeds) > limits).any():
        table.fail(
            key,
            f"exceeds the speed limit {limits.tolist()} rad/s",
            "choose slower wheels or raise [vehicle.wheels] speed_limit_rad_s",
        )
    bands = wheels.avoid
    never = np.asarray(bands.longest_stay)[:, None] == 0.0
    low, high = np.asarray(bands.slowest), np.asarray(bands.fastest)
    size = np.abs(speeds)
    inside = never & (size < high) & ((size > low) | (low == 0.0))
    for k, i in np.argwhere(inside)[:1]:
        table.fail(
            key,
            f"{wheels.names[i]} is at {speeds[i]:g} rad/s, within the {low[k, i]:g} to "
            f"{high[k, i]:g} rad/s that [[vehicle.wheels.avoid]] no. {k + 1} bars",
            "give it a speed outside, or give the band leave_within_s",
        )
