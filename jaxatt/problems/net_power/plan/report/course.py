"""What a plan does over time, in plain arrays, ready to be drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from jaxatt.problems.net_power.plan.task import Task
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class Course:
    """A plan as flown, at K instants.

    tasks : of the plan.  floor : [J], least charge that is allowed; -inf without.
    days : epoch, days since J2000; None without.  time : (K,) [s], since then.
    light : (K,), share of the sun's irradiance.
    solar_power, net_power : (K,) [W].  energy : (K,) [J], net, since the plan's start.
    baseline : (K,) [J], the same of the baseline; not a number where there is none.
    charge : (K,) [J], of the battery.  capacity : [J], inf where there is no battery.
    wheel_speed : (K, n) [rad/s].  rate : (K,) [rad/s], magnitude of the body's rate.
    """

    tasks: Sequence[Task]
    days: float | None
    time: Floats
    light: Floats
    solar_power: Floats
    net_power: Floats
    energy: Floats
    baseline: Floats
    charge: Floats
    capacity: float
    wheel_speed: Floats
    rate: Floats
    floor: float = -math.inf
