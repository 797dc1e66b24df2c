"""Front of net energy against the length of a manoeuvre with wheels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.front import Front, FrontRequest, Quantity, Reference
from jaxatt.problems.net_power.baseline import fly_baseline
from jaxatt.problems.net_power.build import manoeuvre_of, options_of
from jaxatt.problems.net_power.front.neighbours import search_neighbours
from jaxatt.problems.net_power.front.points import ENERGY, gains_of, phases_of
from jaxatt.problems.net_power.wheels.paths import quickest_turn
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

DURATION = Quantity("final time", "final_time_s", "s")
_LONGEST = 1.5
"""Of the scenario's own horizon, where nobody says how long."""
_SHORTEST, _ROOM = (0.1, 0.9), 1.1
"""Of the scenario's own horizon; between these, more than the quickest turn by so much."""


def time_front(scenario: Scenario, asked: FrontRequest, report: Report | None) -> Front:
    """Solve a manoeuvre for several lengths, in as many intervals as the longest one needs.

    No interval is longer than the scenario's own; all lengths have the same number of them, so
    that they are one batch.
    """
    horizon = scenario.horizon
    durations = _durations(scenario, asked.points) if asked.values is None else asked.values
    longest = float(durations.max()) / horizon.duration
    intervals = math.ceil(horizon.intervals * max(1.0, longest) - 1e-9)
    manoeuvres = [
        manoeuvre_of(
            replace(
                scenario,
                horizon=replace(horizon, duration=float(duration), intervals=intervals),
            ),
            PhaseStart(),
        )
        for duration in durations
    ]
    solver, law = scenario.solver, options_of(scenario).baseline
    found = search_neighbours(manoeuvres, solver.starts, solver.seed, report)
    flights = [None if law is None else fly_baseline([one], law) for one in manoeuvres]
    phases = phases_of(found, scenario.family, flights)
    earned = [flight.energy.net_J[0] for flight in flights if flight is not None]
    return Front(
        DURATION,
        durations,
        DURATION,
        durations,
        ENERGY,
        gains_of(phases),
        phases,
        np.array([point.passed_on for point in found]),
        Reference("PD law", durations, np.array(earned)) if earned else None,
    )


def _durations(scenario: Scenario, points: int) -> Floats:
    """Lengths [s] from near the quickest turn to beyond the scenario's own, which is one of them.

    They are closer together where they are short: there the energy depends on them most.
    """
    own = scenario.horizon.duration
    quickest = quickest_turn(wheels_task(manoeuvre_of(scenario, PhaseStart())))
    shortest = float(np.clip(_ROOM * quickest / own, *_SHORTEST))
    durations = own * np.geomspace(shortest, _LONGEST, points)
    if points > 2:
        durations[1 + np.abs(durations[1:-1] - own).argmin()] = own
    return durations
