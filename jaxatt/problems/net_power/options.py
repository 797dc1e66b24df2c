"""What a scenario of net power holds beyond what every scenario has."""

from __future__ import annotations

import math
from dataclasses import dataclass

from jaxatt.problems.net_power.baseline import PDBaseline
from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.weights import Weights as Weights
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class NetPowerOptions:
    """Options of the family `net-power`.

    satellite : what flies, and where.
    initial_frame, target_frame : "inertial" or "orbit", to which initial state and target refer.
    cost : "energy" or "mean-power", of which the most is wanted.
    wheel_speed_at_end : (n,) [rad/s], or None where the wheels may end with any.
    load : [W], of the other subsystems.  floor : [J], least charge of the battery.
    baseline : PD law to compare with; None without.
    tasks : of a plan, in their order; empty for a single manoeuvre.  joint : whether they are
    improved together after they were solved in sequence.
    """

    satellite: Satellite
    initial_frame: str
    target_frame: str
    cost: str
    weights: Weights
    baseline: PDBaseline | None
    wheel_speed_at_end: Floats | None = None
    load: float = 0.0
    floor: float = -math.inf
    tasks: tuple[Task, ...] = ()
    joint: bool = False
