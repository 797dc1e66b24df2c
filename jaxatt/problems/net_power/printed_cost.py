"""Weighted errors at the end, the cost that the source adds to the energy."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.runtime.arrays import Floats


def printed_cost(manoeuvre: Manoeuvre, flight: PoweredFlight) -> Floats:
    """Weighted errors at the end of S flights, (S,) [J]; zero where the end is a constraint.

    Source: Kristiansen (2023), eq. (3.5).
    """
    end = manoeuvre.end
    if end is None or manoeuvre.terminal == "reach":
        return np.zeros(len(flight.q_ib))
    alike = np.abs(flight.q_ib[:, -1] @ end.q_ib)
    cost: Floats = manoeuvre.attitude_weight * (1.0 - alike)
    if manoeuvre.terminal == "rate":
        return cost
    squared = ((flight.omega_ib[:, -1] - end.omega_ib) ** 2).sum(axis=-1)
    cost = cost + manoeuvre.rate_weight * squared
    return cost
