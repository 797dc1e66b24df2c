"""Initial state, target, waypoint and time grid of a manoeuvre."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from jaxatt.environment.table import Surroundings
from jaxatt.problems.end_attitude import EndAttitude
from jaxatt.runtime.arrays import Floats

_LONGEST_SUBSTEP_PHASE = 0.35
"""[rad] of the sinusoidal torque in one RK4 step: four steps in 1.4 s at 1 rad/s."""


def _no_state() -> Floats:
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class InitialState:
    """Initial state of a manoeuvre.

    q_ob : (4,), attitude of the body relative to the orbit frame, unit quaternion, scalar first.
    omega_ob : (3,) [rad/s], rate of the body relative to the orbit frame, in body axes.
    omega_bw : (n,) [rad/s], wheel speeds relative to the body.
    state : (m,), state of a toy system; empty for a spacecraft.
    """

    q_ob: Floats
    omega_ob: Floats
    omega_bw: Floats
    state: Floats = field(default_factory=_no_state)


@dataclass(frozen=True, eq=False)
class Target(EndAttitude):
    """Target of a manoeuvre or of one phase: as `InitialState`, with tolerances [rad, rad/s].

    wheel_bias : (n,) [rad/s], wheel speeds beside those that the momentum asks for; None where
        any will do.
    boresight : see `EndAttitude`.
    """

    q_ob: Floats
    omega_ob: Floats
    attitude_tolerance: float
    rate_tolerance: float
    state: Floats = field(default_factory=_no_state)
    state_tolerance: float = math.inf
    wheel_bias: Floats | None = None
    bias_tolerance: float = math.inf
    boresight: Floats | None = None

    @property
    def pose(self) -> tuple[Floats, Floats]:
        """Attitude and rate; see `EndAttitude.pose`."""
        return self.q_ob, self.omega_ob

    def posed(self, q: Floats, rate: Floats) -> Target:
        """See `EndAttitude.posed`."""
        return replace(self, q_ob=q, omega_ob=rate)

    def reference(self) -> dict[str, Floats]:
        """What a flight is drawn and reported beside."""
        axis = {} if self.boresight is None else {"boresight": self.boresight}
        return {"q_ob": self.q_ob, "omega_ob": self.omega_ob, **axis}


@dataclass(frozen=True, eq=False)
class Waypoint:
    """An attitude to pass at a node: (4,) unit quaternion, time [s], node, tolerance [rad]."""

    q_ob: Floats
    time: float
    node: int
    tolerance: float


@dataclass(frozen=True, eq=False)
class Grid:
    """Time grid of N control intervals of `step` [s], followed by coasting intervals."""

    intervals: int
    step: float
    coast: int
    start_time: float
    substeps: int | None = None


def automatic_substeps(step: float, surroundings: Surroundings) -> int:
    """RK4 steps an interval: one, or as many as a sinusoidal torque needs."""
    if float(surroundings.sine_amplitude) == 0.0:
        return 1
    phase = step * abs(float(surroundings.sine_frequency))
    return max(1, int(np.ceil(phase / _LONGEST_SUBSTEP_PHASE - 1e-9)))


def long_way_probability(turn: Floats, rate: Floats, duration: float) -> float:
    """Probability with which a random start heads for the target the long way round.

    From the rate changes that the two ways ask for about the axis between the attitudes: half where
    both ask for the same, as for half a turn from rest; falling with the fourth power of their
    ratio.

    turn : (3,) [rad], rotation vector the short way.  rate : (3,) [rad/s].  duration : [s].
    """
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return 0.0
    along = float(rate @ turn) / angle
    short, long = angle / duration, (2.0 * np.pi - angle) / duration
    short_way, long_way = abs(short - along) + short, abs(long + along) + long
    return float(short_way**4 / (short_way**4 + long_way**4))
