"""Record of cones and rate limits along a flight."""

from __future__ import annotations

from dataclasses import dataclass

from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True)
class Extreme:
    """Instant of a flight at which it is closest to violating one limit.

    kind : "keep-out", "keep-in" or "body-rate".  value, allowed : [rad], or [rad/s] of a rate.
    time : [s] after the first instant.  satisfied : whether the limit holds, to one millionth.
    """

    name: str
    kind: str
    value: float
    allowed: float
    time: float
    satisfied: bool


@dataclass(frozen=True, eq=False)
class PointingRecord:
    """Cones and rate limits of a phase at every Runge-Kutta step of its flight.

    time : (T,) [s] from the phase's start, the coast included.
    angles : (T, m) [rad], of m cones.  boresights, directions : (T, m, 3), in inertial axes.
    extremes : the worst instant before the end of the horizon, one a cone, then of the rate.
    constraint_margin : by how much the search took the cones stricter than they are, (m,) [rad].
    """

    time: Floats
    angles: Floats
    boresights: Floats
    directions: Floats
    extremes: tuple[Extreme, ...]
    constraint_margin: Floats
