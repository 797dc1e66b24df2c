"""Limits that a flight breaks on its way, in words: wheel speeds, and the battery's floor."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.judge import charge_scale
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.verdict import Verdict

_JOULE = 3600.0  # in a watt hour


def broken_margins(manoeuvre: Manoeuvre, flight: PoweredFlight, row: int) -> list[str]:
    """Sentences on the wheels that are too fast, and on the charge that is missing.

    row : of some flights of the manoeuvre.
    """
    wheels = manoeuvre.satellite.craft.wheels
    most = np.asarray(wheels.speed_limit)
    over = flight.fastest[row] / most - 1.0
    found = [
        f"{wheels.names[index]} exceeds its speed limit of {most[index]:g} rad/s by "
        f"{100.0 * over[index]:.3g} %"
        for index in np.flatnonzero(over > Verdict.MARGIN_TOLERANCE)
    ]
    charge = flight.energy.charge[row]
    missing = manoeuvre.floor - float(flight.energy.least_charge[row])
    if missing > Verdict.MARGIN_TOLERANCE * charge_scale(manoeuvre, flight):
        time = float(flight.step[row]) * int(np.argmin(charge))
        found.append(
            f"the battery falls {missing / _JOULE:.3g} Wh below its floor of "
            f"{manoeuvre.floor / _JOULE:.4g} Wh, {time:g} s after the beginning"
        )
    return found
