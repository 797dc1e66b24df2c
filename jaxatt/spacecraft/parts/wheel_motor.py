"""Motors of reaction wheels: friction that they work against, and torque that falls with speed.

The motor's torque is what accelerates the wheel and what its friction takes.  Its limit is that of
a motor at a fixed voltage: whole up to one speed, from there falling on a line to nothing at
another, while it drives; braking, the voltage that the motor itself induces helps, and the limit is
whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.spacecraft.checks import FieldError, positive_per_item
from jaxatt.spacecraft.parts.array import Array


@dataclass(frozen=True, eq=False)
class WheelMotors:
    """Motors of n wheels; build them with `wheel_motors`.

    Attributes
    ----------
    coulomb : (n,) array [N m]
        Dry friction, which does not depend on the speed.
    viscous : (n,) array [N m s]
        Friction for each rad/s.
    full_torque_speed : (n,) array [rad/s]
        Speed up to which the whole torque is there.
    torque_fall : (n,) array [s/rad]
        Share of the torque that is lost for each rad/s above it; 0 where it does not fall.
    """

    coulomb: Array
    viscous: Array
    full_torque_speed: Array
    torque_fall: Array

    def of_wheels(self, places: Sequence[int]) -> WheelMotors:
        """The motors of some of the wheels."""
        every = (self.coulomb, self.viscous, self.full_torque_speed, self.torque_fall)
        return WheelMotors(*(np.asarray(values)[list(places)] for values in every))

    @property
    def rubbing(self) -> bool:
        """Whether there is friction."""
        return any(np.any(np.asarray(effect)) for effect in (self.coulomb, self.viscous))

    @property
    def ideal(self) -> bool:
        """Whether there is no friction and the torque does not fall."""
        return not self.rubbing and not np.any(np.asarray(self.torque_fall))


def wheel_motors(
    count: int,
    coulomb: Any = 0.0,
    viscous: Any = 0.0,
    full_torque_speed: Any = np.inf,
    no_torque_speed: Any = np.inf,
) -> WheelMotors:
    """Return checked motors of `count` wheels.

    Parameters
    ----------
    coulomb, viscous : float or (n,) array_like [N m], [N m s]
    full_torque_speed, no_torque_speed : float or (n,) array_like [rad/s]
        Where the torque begins to fall, and where none is left; without the latter it does not.

    Raises
    ------
    FieldError
        Of these names.
    """
    dry = positive_per_item("coulomb", coulomb, count, zero=True)
    wet = positive_per_item("viscous", viscous, count, zero=True)
    full, none = (
        positive_per_item(name, speed, count, zero=True, infinite=True)
        for name, speed in (
            ("full_torque_speed", full_torque_speed),
            ("no_torque_speed", no_torque_speed),
        )
    )
    falls = np.isfinite(none)
    if (np.isfinite(full) & ~falls).any():
        raise FieldError(
            "full_torque_speed",
            "is given without the speed at which no torque is left; give no_torque_speed_rad_s as "
            "well",
        )
    full = np.where(np.isinf(full) & falls, 0.0, full)
    if (falls & (none <= full)).any():
        raise FieldError(
            "no_torque_speed",
            f"is {none.tolist()}, not above the speeds {full.tolist()} up to which the whole "
            "torque is there; give a higher speed",
        )
    full = np.where(falls, full, 0.0)
    fall = np.where(falls, 1.0 / np.where(falls, none - full, 1.0), 0.0)
    return WheelMotors(dry, wet, full, fall)
