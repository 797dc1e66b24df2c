"""Verdict of a fine flight on answers to a manoeuvre that earns energy."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.attitude import errors
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.net_power.flight import PoweredFlight, fly
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import overstay, speed_excess
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.scale import least_torque_limit

SPEED_TOLERANCE = 1e-3
"""[rad/s], for wheel speeds at the end where a manoeuvre asks for them."""


def judge_manoeuvre(manoeuvre: Manoeuvre, wheel_torque: Any, dipole: Any = None) -> Verdict:
    """Fly answers finely and judge them; wheel_torque (S, N, n) and dipole as in `fly`."""
    return judge_flight(manoeuvre, fly(manoeuvre, wheel_torque, dipole), dipole is not None)


def judge_flight(
    manoeuvre: Manoeuvre, flown: PoweredFlight, decided_dipole: bool = False
) -> Verdict:
    """Judge flights of one manoeuvre.

    Errors: "attitude" [rad], "rate" [rad/s] and, where wheel speeds are asked for, "wheel speed"
    [rad/s], of the worst wheel.  Limits: torques [N m] and, where they were decided, dipoles
    [A m^2].  Margins: speeds of the wheels at all steps, relative to their limits, and the charge
    of the battery at the nodes, relative to its capacity, or where that has no bound to its floor
    or its charge at the start.
    """
    found: dict[str, Floats] = {}
    tolerances: dict[str, float] = {}
    end = manoeuvre.end
    if end is not None:
        end = end.facing(flown.q_ib[:, -1])
        found["attitude"] = np.asarray(errors.angle(end.q_ib, flown.q_ib[:, -1]))
        found["rate"] = np.linalg.norm(flown.omega_ib[:, -1] - end.omega_ib, axis=-1)
        tolerances = {"attitude": end.attitude_tolerance, "rate": end.rate_tolerance}
        if end.omega_bw is not None:
            missed = np.abs(flown.omega_bw[:, -1] - end.omega_bw)
            found["wheel speed"] = missed.max(axis=-1, initial=0.0)
            tolerances["wheel speed"] = SPEED_TOLERANCE
    craft = manoeuvre.satellite.craft
    least = least_torque_limit(craft)
    if decided_dipole and craft.magnetorquers is not None:
        least = min(least, float(np.min(np.asarray(craft.magnetorquers.dipole_limit))))
    return Verdict(
        {name: _finite(error) for name, error in found.items()},
        tolerances,
        _limits(manoeuvre, flown, decided_dipole),
        np.maximum(_speeds(manoeuvre, flown), _floor(manoeuvre, flown)),
        least,
    )


def _finite(error: Floats) -> Floats:
    return np.where(np.isfinite(error), error, np.inf)


def _limits(manoeuvre: Manoeuvre, flown: PoweredFlight, decided_dipole: bool) -> Floats:
    """Largest excess over a limit of torque or decided dipole, (S,)."""
    craft = manoeuvre.satellite.craft
    excess = np.abs(flown.wheel_torque) - np.asarray(craft.wheels.torque_limit)
    worst = excess.max(axis=(1, 2), initial=0.0)
    if decided_dipole and craft.magnetorquers is not None:
        over = flown.strongest - np.asarray(craft.magnetorquers.dipole_limit)
        worst = np.maximum(worst, over.max(axis=1))
    return _finite(worst)


def _speeds(manoeuvre: Manoeuvre, flown: PoweredFlight) -> Floats:
    """Largest way out of the range of a wheel's speed, overstay in a band, or excess of a motor,
    relative, (S,)."""
    wheels = manoeuvre.satellite.craft.wheels
    over = speed_excess(wheels, flown.speeds_passed).max(axis=1, initial=0.0)
    strained = motor_excess(wheels, flown.wheel_torque, flown.omega_bw).max(axis=1, initial=0.0)
    late = overstay(wheels, flown.omega_bw, flown.step)
    return _finite(np.maximum.reduce([over, late, strained]))


def _floor(manoeuvre: Manoeuvre, flown: PoweredFlight) -> Floats:
    """Charge that is missing to the battery's floor, relative, (S,)."""
    missing = np.maximum(manoeuvre.floor - flown.energy.least_charge, 0.0)
    if not np.isfinite(manoeuvre.floor):
        return np.zeros(len(missing))
    return _finite(missing / charge_scale(manoeuvre, flown))


def charge_scale(manoeuvre: Manoeuvre, flown: PoweredFlight) -> float:
    """Charge [J] against which what is missing to the battery's floor is small or large."""
    capacity = float(flown.energy.capacity)
    if np.isfinite(capacity):
        return capacity
    return max(abs(manoeuvre.floor), abs(manoeuvre.charge), float(np.finfo(float).tiny))
