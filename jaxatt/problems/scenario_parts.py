"""Parts of a scenario that are plain numbers, for readers that need no JAX."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Horizon:
    """Duration [s], control intervals, coasting intervals after the end, RK4 steps an interval.

    `substeps` is None where the number is chosen automatically.
    free : whether the final time of each phase is found, from `shortest` to `longest` [s]; the
    number of intervals stays and their length changes.  `duration` is then the first one to be
    tried, or `longest` where the objective minimises time.
    """

    duration: float
    intervals: int
    coast_intervals: int
    substeps: int | None
    free: bool = False
    shortest: float = 0.0
    longest: float = math.inf

    @property
    def step(self) -> float:
        """Length of one control interval [s]."""
        return self.duration / self.intervals


@dataclass(frozen=True)
class Disturbances:
    """Known torques: gravity gradient on or off, amplitude [N m] and frequency [rad/s] of a sine.

    Schaanning (2021), eqs. 4.11 and 4.12.
    """

    gravity_gradient: bool
    sinusoidal_torque: float
    sinusoidal_frequency: float


@dataclass(frozen=True)
class Control:
    """Axes of the decision variables ("body" or "wheels"); control bound of a toy system.

    With thrusters the variables are the torques of the actuators: wheels, then thrusters.
    quantisation : "pulse-width", "interval" or "none", how thrusters are made fully open or shut.
    """

    axes: str
    limit: float
    quantisation: str = "none"


@dataclass(frozen=True)
class Objective:
    """Objective with its weights k1 [s^2], k2, k3, a3 of Schaanning (2021), table 5.1.

    Attributes
    ----------
    kind : one of those of a family, see `jaxatt.problems.registry.kinds`
    terminal : "reach" or "penalty"
        Terminal constraints with tolerances, or the printed cost.
    design : 1, 2 or 3
        One complementarity vector for all axes (eq. 5.3) or one an axis (eqs. 5.14, 5.15).
    epsilon : float [N m]
        Relaxation of the complementarity, on the unscaled torque (or a toy's control).
    on_off_weight : float [1/(N m)^2]
        k4 of Kristiansen and Gravdahl (2023), eq. 11, on partially open thrusters.
    on_off_form : "active" or "printed"
        Whether the term counts in active intervals (1 - xi) or, as printed, in idle ones (xi).
    time_weight : float [1/s]
        Cost of a second of free final time, in active intervals.
    effort_weight : float [1/(N m)^2]
        rho, cost in seconds of a unit of the integral of all squared torques; of "time-effort".
    """

    kind: str
    terminal: str = "reach"
    design: int = 1
    epsilon: float = 1e-8
    rate_weight: float = 1e6
    attitude_weight: float = 1e2
    sparsity_weight: float = 1e1
    waypoint_weight: float = 1e2
    on_off_weight: float = 0.0
    on_off_form: str = "active"
    time_weight: float = 0.0
    effort_weight: float = 0.0


@dataclass(frozen=True)
class Transcription:
    """Transcription of a turn in free time to a finite programme.

    attitude : "quaternion" or "mrp", its coordinates.  integration : "rk4" or "euler".
    """

    attitude: str = "quaternion"
    integration: str = "rk4"


@dataclass(frozen=True)
class Window:
    """Intervals `first` to `last`, zero-based and inclusive, that are cheap or forbidden.

    `weight` replaces the cost 1 of an active interval in moving L0 (h_N of eq. 5.5); in a
    forbidden window no objective may use torque, and the weight is 1.
    """

    first: int
    last: int
    weight: float
    forbidden: bool


@dataclass(frozen=True)
class SolverSettings:
    """Number of starts and the seed they are drawn from."""

    starts: int
    seed: int


UNDISTURBED = Disturbances(False, 0.0, 1.0)
BODY_TORQUE = Control("body", math.inf)
USUAL = Transcription()
"""What a scenario has where its file says nothing."""
