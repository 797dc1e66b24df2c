"""Limits that a flight breaks on its way, in words: wheel speeds, and the battery's floor."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.motor_torques import broken_motors
from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.judge import charge_scale
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import broken_speeds

_JOULE = 3600.0  # in a watt hour


def broken_margins(manoeuvre: Manoeuvre, flight: PoweredFlight, row: int) -> list[str]:
    """Sentences on the wheels that are too fast, and on the charge that is missing.

    row : of some flights of the manoeuvre.
    """
    wheels, speeds = manoeuvre.satellite.craft.wheels, flight.omega_bw[row]
    found = broken_speeds(wheels, speeds, float(flight.step[row]), flight.speeds_passed[row])
    found += broken_motors(wheels, flight.wheel_torque[row], speeds)
    charge = flight.energy.charge[row]
    missing = manoeuvre.floor - float(flight.energy.least_charge[row])
    if missing > Verdict.MARGIN_TOLERANCE * charge_scale(manoeuvre, flight):
        time = float(flight.step[row]) * int(np.argmin(charge))
        found.append(
            f"the battery falls {missing / _JOULE:.3g} Wh below its floor of "
            f"{manoeuvre.floor / _JOULE:.4g} Wh, {time:g} s after the beginning"
        )
    return found
