"""Front of net energy against the error of attitude at the end of a manoeuvre with wheels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.front import Front, FrontRequest, Quantity, Reference
from jaxatt.problems.net_power.baseline import fly_baseline
from jaxatt.problems.net_power.build import manoeuvre_of, options_of
from jaxatt.problems.net_power.front.neighbours import search_neighbours
from jaxatt.problems.net_power.front.points import ENERGY, best_power, gains_of, phases_of
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.chunks import Report

WEIGHT = Quantity("weight of the attitude", "attitude_weight_J", "J", logarithmic=True)
ERROR = Quantity("attitude error", "attitude_error_deg", "deg", logarithmic=True)
_LEAST, _MOST = 0.01, 100.0
"""Weights where nobody says which, as shares of what the sun could give in all the time."""


def error_front(scenario: Scenario, asked: FrontRequest, report: Report | None) -> Front:
    """Solve a manoeuvre for several weights of the attitude at its end, and fly all answers.

    Its rate at the end stays a constraint, within the scenario's tolerance.  The cost is that of
    (3.5) of Kristiansen (2023) without the rate's part.
    """
    options = options_of(scenario)
    if not scenario.targets:
        raise ScenarioError(
            f"{scenario.name}: [target] has no attitude, so there is no error at the end; give one"
        )
    if scenario.leaves_roll_free:
        raise ScenarioError(
            f"{scenario.name}: [target] leaves the roll free, and this front weighs the error of "
            "the whole attitude; add constrain beside align, or ask for the front of time"
        )
    if options.wheel_speed_at_end is not None:
        raise ScenarioError(
            f"{scenario.name}: [target] wheel_speed_rad_s: not together with an attitude that may "
            "be missed, as the wheels' momentum follows from where the satellite ends; drop it"
        )
    # The verdict asks for the rate alone: whatever the error, it is a point of the front.
    target = replace(scenario.targets[0], attitude_tolerance=math.pi)
    anywhere = manoeuvre_of(replace(scenario, targets=(target,)), PhaseStart())
    weights = asked.values
    if weights is None:
        most = best_power(anywhere.satellite) * anywhere.duration
        weights = most * np.geomspace(_LEAST, _MOST, asked.points)
    manoeuvres = [
        replace(anywhere, terminal="rate", attitude_weight=float(weight)) for weight in weights
    ]
    solver, law = scenario.solver, options.baseline
    found = search_neighbours(manoeuvres, solver.starts, solver.seed, report)
    flight = None if law is None else fly_baseline([anywhere], law)
    phases = phases_of(found, scenario.family, [flight] * len(found))
    reference = None
    if flight is not None:
        missed = np.degrees(judge_flight(anywhere, flight).errors["attitude"])
        reference = Reference("PD law", missed, flight.energy.net_J)
    return Front(
        WEIGHT,
        weights,
        ERROR,
        np.degrees([phase.errors["attitude"] for phase in phases]),
        ENERGY,
        gains_of(phases),
        phases,
        np.array([point.passed_on for point in found]),
        reference,
    )
