"""What a target that leaves the roll free may not ask for beside it, where energy is weighed."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.pose import Pose
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.scenario import Horizon
from jaxatt.runtime.arrays import Floats

_AT_REST = 1e-9
"""[rad/s] Rate of a mean axis whose momentum counts as none."""


def check_free_roll(table: Table, horizon: Horizon, terminal: str) -> None:
    """Refuse a target that leaves the roll free where attitudes are decided in another way."""
    problem = ""
    if horizon.free:
        problem = "missing beside align; manoeuvres by magnetorquers alone leave no roll free"
    elif terminal == "penalty":
        problem = 'missing beside align; terminal = "penalty" weighs the whole attitude'
    if problem:
        mend = 'add constrain = { body = [1.0, 0.0, 0.0], toward = "velocity" }'
        table.fail("constrain", problem, mend if horizon.free else f'use "reach", or {mend}')


def check_held_speeds(
    data: Any, origin: str, satellite: Satellite, pose: Pose, speeds: Floats
) -> None:
    """Refuse wheel speeds that a roll decides, where body or wheels bring momentum along."""
    craft = satellite.craft
    momentum = np.asarray(craft.inertia) @ pose.omega_ib
    momentum = momentum + np.asarray(craft.wheels.axes) @ (craft.wheels.inertia * speeds)
    mean = float(np.trace(np.asarray(craft.inertia))) / 3.0
    if satellite.decided_dipole or np.linalg.norm(momentum) <= _AT_REST * mean:
        return
    Table(data, origin, "[target]", NET_POWER_TABLES["target"]).fail(
        "wheel_speed_rad_s",
        "not beside a roll that is free, which decides what the wheels must hold of the momentum "
        "that body and wheels begin with",
        'drop it, or add constrain = { body = [1.0, 0.0, 0.0], toward = "velocity" }',
    )
