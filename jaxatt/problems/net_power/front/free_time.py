"""Front of energy against the final time of a manoeuvre by magnetorquers alone."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.front import Front, FrontRequest, Quantity
from jaxatt.problems.net_power.build import free_manoeuvre_of, options_of
from jaxatt.problems.net_power.front.points import ENERGY, best_power, gains_of
from jaxatt.problems.net_power.front.time import DURATION
from jaxatt.problems.net_power.magnetic.judge import fly_found
from jaxatt.problems.net_power.magnetic.search import search_front
from jaxatt.problems.net_power.phase import phase_of
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.chunks import Report

_POWER = Quantity("mean net power", "mean_power_W", "W")
_LEAST, _MOST = 1e-2, 1e2
"""Weights where nobody says which, as shares of the best power, or of that by the longest time."""


def free_time_front(scenario: Scenario, asked: FrontRequest, report: Report | None) -> Front:
    """Solve a manoeuvre in free time for several weights of time.

    What is gained is net energy, or mean power where the scenario's cost is that.
    """
    by_power = options_of(scenario).cost == "mean-power"
    manoeuvre, solver = free_manoeuvre_of(scenario, PhaseStart()), scenario.solver
    weights = asked.values
    if weights is None:
        unit = best_power(manoeuvre.satellite) / (manoeuvre.longest if by_power else 1.0)
        weights = unit * np.geomspace(_LEAST, _MOST, asked.points)
    found = search_front(manoeuvre, weights, solver.starts, solver.seed, report)
    phases = tuple(
        phase_of(fly_found(found, k), scenario.family, None, free_time=True)[0]
        for k in range(len(weights))
    )
    times = np.array([phase.final_time for phase in phases])
    varied = Quantity(
        "weight of time", "time_weight_W_s", "W/s" if by_power else "J/s", logarithmic=True
    )
    energy = gains_of(phases)
    return Front(
        varied,
        weights,
        DURATION,
        times,
        _POWER if by_power else ENERGY,
        energy / times if by_power else energy,
        phases,
        np.zeros(len(weights), bool),
    )
