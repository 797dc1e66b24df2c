"""A closed-loop flight as checked data, in SI units and radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.control.feedback import FeedbackLaw
from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment.external import ExternalTorques
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.scenario import Orbit
from jaxatt.simulation.campaign import Spread
from jaxatt.spacecraft import Spacecraft
from jaxatt.spacecraft.checks import Float64


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Orbit, epoch and disturbing torques of a flight.

    orbit : None where the frame of reference is inertial.  days : epoch, since J2000; None where
    nothing asks.
    sun : (3,), fixed direction of an always shining sun, or None for the true one.
    """

    orbit: Orbit | None
    days: float | None
    gravity_gradient: bool
    sine: float
    frequency: float
    sun: Float64 | None
    torques: ExternalTorques


@dataclass(frozen=True, eq=False)
class Asked:
    """Reference that the laws follow from `since` [s] on; before, the start's attitude at rest.

    q_ob : (4,).  omega_ob : (3,) [rad/s], in body axes; the attitude turns along with it.
    held : whether the attitude is to be held, or only the rate.
    manoeuvre : name or file of a scenario whose optimised answer is flown instead, or "".
    path : inertial attitudes that are followed instead, by time from the start: those of a file, or
        where directions lead.
    """

    q_ob: Float64
    omega_ob: Float64
    since: float
    held: bool
    manoeuvre: str
    path: AttitudePath | None = None


@dataclass(frozen=True)
class Timing:
    """Duration, sampling period (zero-order hold), Runge-Kutta step [s], and number of records."""

    duration: float
    sampling: float
    step: float
    records: int
    tumbling: float

    @property
    def samples(self) -> int:
        """Number of sampling instants."""
        return round(self.duration / self.sampling)

    @property
    def steps(self) -> int:
        """Number of Runge-Kutta steps a sample."""
        return round(self.sampling / self.step)


@dataclass(frozen=True, eq=False)
class FlightScenario:
    """A closed-loop case with the laws that fly it.

    signal : "attitude" or "rate", what must settle; band : its width [rad] or [rad/s]; since : [s].
    noise : deviations of rate and wheel speed [rad/s].
    laws : by name, the first is the default.  law_titles : as tables show them.
    printed : by law, what the source prints.
    """

    name: str
    title: str
    source: str
    vehicle: Spacecraft
    surroundings: Surroundings
    initial: InitialState
    asked: Asked
    timing: Timing
    signal: str
    band: float
    since: float
    noise: tuple[float, float]
    dumping: MomentumDumping | None
    laws: Mapping[str, FeedbackLaw]
    law_titles: Mapping[str, str]
    spread: Spread
    runs: int
    seed: int
    printed: Mapping[str, Any]
    notes: tuple[str, ...]
    document: Mapping[str, Any] = field(repr=False)
    origin: str = field(repr=False)
    folder: Path | None = field(repr=False)
