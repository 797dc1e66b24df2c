"""A manoeuvre by magnetorquers alone, whose final time is found with the rest."""

from __future__ import annotations

from dataclasses import dataclass

from jaxatt.problems.manoeuvre import Target
from jaxatt.problems.net_power.manoeuvre import Motion, Satellite


@dataclass(frozen=True, eq=False)
class FreeManoeuvre:
    """Manoeuvre in free time.

    satellite : with panels and magnetorquers, without wheels.  start : in inertial axes.
    target : attitude and rate to end in, relative to `frame`, "orbit" or "inertial".
    start_time : [s] since the epoch.  shortest, longest : [s], of the final time.
    intervals : equal ones.  substeps : Runge-Kutta steps an interval; None for as many as the
    motion asks for.
    cost : "mean-power" (6.2a) or "energy".  terminal : "reach" or "penalty" (6.6), with weights
    k1 [W or J], k2 [W s^2 or J s^2] and k3 [W/s or J/s] of attitude, rate and time.
    load : [W], of the other subsystems.  charge : [J], of the battery at the start.
    """

    satellite: Satellite
    start: Motion
    target: Target
    frame: str
    intervals: int
    shortest: float
    longest: float
    start_time: float = 0.0
    cost: str = "energy"
    terminal: str = "reach"
    attitude_weight: float = 0.0
    rate_weight: float = 0.0
    time_weight: float = 0.0
    load: float = 0.0
    charge: float = 0.0
    substeps: int | None = None
