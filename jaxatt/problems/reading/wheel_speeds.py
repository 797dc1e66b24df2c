"""Wheel speeds in a scenario's tables: one for each wheel that is mounted."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.reading.fields import Table
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import ReactionWheels


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
    limits = np.asarray(wheels.speed_limit)
    if (np.abs(kept) > limits).any():
        table.fail(
            key,
            f"exceeds the speed limit {limits.tolist()} rad/s",
            "choose slower wheels or raise [vehicle.wheels] speed_limit_rad_s",
        )
    return kept
