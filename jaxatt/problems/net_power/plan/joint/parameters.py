"""Parameters of all tasks of a plan as one programme."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import jax
from jax import Array

from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage


class Crossing(NamedTuple):
    """A task of prescribed attitude as one stage, across which the wheels' momentum is mapped.

    begin, end : (4,), attitudes q_ib.  rate : (3,) [rad/s], at which it turns.
    mapping : (k, k) and offset : (k,), of the coordinates y of the wheels' momentum.
    turned : (3, 3), R(end) J_s over the scale of momentum.
    spent : (), energy over the scale of energy at y = around, without the loads; slope : (k,) and
    bend : (k, k), its derivatives by y.  drained : (), loads over the scale of energy.
    """

    begin: Array
    end: Array
    rate: Array
    mapping: Array
    offset: Array
    turned: Array
    spent: Array
    slope: Array
    bend: Array
    around: Array
    drained: Array


class JointStage(NamedTuple):
    """A stage of the plan: an interval of a harvest, or a whole task of prescribed attitude.

    crossing : () 1 for a task, 0 for an interval.  interval, across : what each of them needs; the
    other one's is there, but not read.  load : () [W], of the interval.
    speed_lower, speed_upper : (n,) [rad/s] and motor_limit : (n,), as in `WheelsParameters`.
    """

    crossing: Array
    interval: WheelStage
    across: Crossing
    load: Array
    speed_lower: Array
    speed_upper: Array
    motor_limit: Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class JointParameters:
    """Parameters of a plan; every leaf may be batched.

    wheels : of a harvest, whose own stages are not read.  stages : leading axis of all stages.
    """

    wheels: WheelsParameters
    stages: JointStage
