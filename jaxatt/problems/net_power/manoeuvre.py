"""A manoeuvre between two attitudes, and the satellite and surroundings that it earns energy in."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.light import Light
from jaxatt.problems.end_attitude import EndAttitude
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import Spacecraft


@dataclass(frozen=True, eq=False)
class Motion:
    """State of a satellite: q_ib (4,), omega_ib (3,) [rad/s] and wheel speeds omega_bw (n,)
    [rad/s]."""

    q_ib: Floats
    omega_ib: Floats
    omega_bw: Floats


@dataclass(frozen=True, eq=False)
class End(EndAttitude):
    """State to end in, with tolerances [rad, rad/s].

    omega_bw : (n,) [rad/s], wheel speeds to end with; None leaves them free.
    boresight : see `EndAttitude`.
    """

    q_ib: Floats
    omega_ib: Floats
    attitude_tolerance: float
    rate_tolerance: float
    omega_bw: Floats | None = None
    boresight: Floats | None = None

    @property
    def pose(self) -> tuple[Floats, Floats]:
        """Attitude and rate; see `EndAttitude.pose`."""
        return self.q_ib, self.omega_ib

    def posed(self, q: Floats, rate: Floats) -> End:
        """See `EndAttitude.posed`."""
        return replace(self, q_ib=q, omega_ib=rate)


@dataclass(frozen=True, eq=False)
class MomentumManagement:
    """Magnetorquers that hold the wheels' momentum near a reference, eqs. (5.14) and (5.15).

    gain : k_m, positive.  wheel_speed : (n,) [rad/s], reference.  The signs of the source pump
    momentum; here a positive gain dumps it.
    """

    gain: float
    wheel_speed: Floats


@dataclass(frozen=True, eq=False)
class Satellite:
    """Satellite and surroundings, the same in every manoeuvre of a plan.

    craft : with panels, and where it has them battery, wheels and magnetorquers.
    light : sun and eclipse.  orbit : None where sun and attitude are all that matters.
    torques : external ones; gravity_gradient : whether that acts, too.
    momentum : None where the magnetorquers do nothing, or where the optimiser decides them.
    wheel_power : "signed" (4.6), "body" (5.7) or "wheels", each wheel by itself.
    decided_dipole : whether the optimiser decides the magnetorquers' dipole.
    """

    craft: Spacecraft
    light: Light
    orbit: OrbitTask | None = None
    torques: ExternalTorques = field(default_factory=ExternalTorques)
    gravity_gradient: bool = False
    momentum: MomentumManagement | None = None
    wheel_power: str = "wheels"
    decided_dipole: bool = False


@dataclass(frozen=True, eq=False)
class WheelLimits:
    """How a search keeps to what wheels can do: their speeds, and the torque of their motors.

    slower : (n,), shares by which speed limits are taken stricter than they are, and weaker : (n,)
    those of the motors' torque.  every_band : whether bands that may be crossed are barred, too.
    """

    slower: Floats
    weaker: Floats
    every_band: bool = False


@dataclass(frozen=True, eq=False)
class Manoeuvre:
    """One manoeuvre of fixed length [s] in equal intervals.

    start_time : [s] since the epoch of the orbit.  end : None where it may end anywhere.
    terminal : of attitude and rate at the end: "reach", both constraints; "penalty", the weights of
    (3.5), attitude_weight [J] and rate_weight [J s^2]; "rate", a constraint on the rate alone and
    the weight of the attitude.
    load : [W], of the other subsystems.  substeps : Runge-Kutta steps an interval; None for as many
    as the motion asks for.
    floor : [J], charge of the battery below which it must not fall; -inf without.
    charge : [J], of the battery at the start.
    limits : that the search keeps the wheels to; None where it does not count them.
    """

    satellite: Satellite
    start: Motion
    end: End | None
    start_time: float
    duration: float
    intervals: int
    load: float = 0.0
    terminal: str = "reach"
    attitude_weight: float = 0.0
    rate_weight: float = 0.0
    substeps: int | None = None
    floor: float = -math.inf
    charge: float = 0.0
    limits: WheelLimits | None = None

    @property
    def step(self) -> float:
        """Length of one interval [s]."""
        return self.duration / self.intervals
