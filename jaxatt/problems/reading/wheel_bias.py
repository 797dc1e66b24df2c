"""Wheel speeds at the end, in the null space of the mounting, in a target's table."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.wheel_speeds import read_wheel_speeds
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.parts.wheels import ReactionWheels
from jaxatt.spacecraft.wheel_bias import bias_of, unit_bias

BIAS, TOLERANCE = "wheel_bias_rad_s", "wheel_bias_tolerance_rad_s"
_ROUNDED = 1e-3
"""Share of a bias that may lie outside of the null space, as rounded numbers do."""


def read_bias(table: Table, wheels: ReactionWheels | None) -> Floats | None:
    """Read the speeds (n,) [rad/s] that the wheels shall have at the end beside those that the
    momentum asks for; None without.

    One number, along the null vector of unit norm of four wheels, or a list with one entry for each
    wheel that is mounted, which must store no momentum.
    """
    if BIAS not in table:
        if TOLERANCE in table:
            table.fail(TOLERANCE, f"given without {BIAS}", f"add {BIAS}, or drop it")
        return None
    if wheels is None or wheels.count < 4:
        left = 0 if wheels is None else wheels.count
        table.fail(
            BIAS,
            f"{left} wheels have no speeds that store no momentum, which takes at least four",
            "drop it",
        )
    if not isinstance(table.data[BIAS], list):
        if wheels.count > 4:
            table.fail(
                BIAS,
                f"{wheels.count} wheels have more than one such direction",
                f"give a list of {len(wheels.mounted_names)} speeds",
            )
        return np.asarray(table.number(BIAS) * unit_bias(wheels))
    speeds = read_wheel_speeds(table, wheels, BIAS)
    nearest = bias_of(wheels, speeds)
    if np.linalg.norm(speeds - nearest) > _ROUNDED * np.linalg.norm(speeds):
        told = np.zeros(len(wheels.mounted_names))
        told[list(wheels.working)] = nearest
        table.fail(
            BIAS,
            "stores momentum, so that the attitude at the end does not leave it free",
            f"the nearest that stores none is {[float(f'{v:.6g}') for v in told]}",
        )
    return nearest
