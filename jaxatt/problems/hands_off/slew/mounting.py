"""Map from the controls of an interval to torques, with units and limits.

Without thrusters the controls are torques on the wheels, in body axes or wheel by wheel; with
thrusters they are those of the actuators themselves, wheels first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.vehicle import Spacecraft


@dataclass(frozen=True, eq=False)
class Mounting:
    """Maps and limits of the b controls, all on the host.

    scale : (b,) [N m], what a scaled control of one stands for.
    to_body : (3, b), torque on the wheels in body axes of a unit of each control.
    to_external : (3, b), torque of the thrusters in body axes.
    to_wheel : (n, b), torque on each wheel.  to_thrust : (m, b), torque of each thruster.
    lower, upper : (b,), limits of the scaled controls, where each has its own; a wheel's torque
        in body axes is limited through `to_wheel` only.
    """

    scale: Floats
    to_body: Floats
    to_external: Floats
    to_wheel: Floats
    to_thrust: Floats
    lower: Floats
    upper: Floats


def mounting(craft: Spacecraft, axes: str) -> Mounting:
    """Controls of a vehicle.

    axes : "body" or "wheels", for vehicles without thrusters.
    """
    wheels, thrusters = craft.wheels, craft.thrusters
    n, m = wheels.count, thrusters.count
    limit = np.asarray(wheels.torque_limit)
    if m == 0 and axes == "body":
        return Mounting(
            np.full(3, limit.max()),
            np.eye(3),
            np.zeros((3, 3)),
            np.asarray(wheels.allocation),
            np.zeros((0, 3)),
            np.full(3, -np.inf),
            np.full(3, np.inf),
        )
    each = np.eye(n + m)
    # Without thrusters a torque beyond the limits keeps its direction rather than each its own.
    most = np.ones(n) if m else np.full(n, np.inf)
    return Mounting(
        np.concatenate([limit, np.asarray(thrusters.torque_limit)]),
        np.concatenate([np.asarray(wheels.axes), np.zeros((3, m))], axis=1),
        np.concatenate([np.zeros((3, n)), np.asarray(thrusters.distribution)], axis=1),
        each[:n],
        each[n:],
        np.concatenate([-most, np.zeros(m)]),
        np.concatenate([most, np.ones(m)]),
    )
