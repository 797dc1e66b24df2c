"""Answers to one phase as functions of what they depend on."""

from __future__ import annotations

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import Answers, flown_again, phase_manoeuvre
from jaxatt.problems.net_power.wheels.sensitive import sensitive_wheels
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer


def sensitive_manoeuvre(scenario: Scenario, start: PhaseStart, found: Answers) -> SensitiveAnswer:
    """The answer that a report shows, polished."""
    if found.free is not None:
        raise ScenarioError(
            f"{scenario.name}: answers by magnetorquers in free time have no sensitivities yet; "
            'use a vehicle with wheels, and final_time = "fixed"'
        )
    if found.solved is None:
        raise ScenarioError(
            f"{scenario.name}: this task prescribes the attitude, so that nothing is decided; ask "
            "for the sensitivities of a harvest"
        )
    flown = flown_again(phase_manoeuvre(scenario, start), found.solved)
    weighed = scenario.objective.terminal == "penalty"
    if not weighed and not flown.reached[flown.best]:
        raise ScenarioError(
            f"{scenario.name}: no start reaches the target, so there is no answer to "
            "differentiate; give more starts, or more time"
        )
    return sensitive_wheels(scenario, lambda s: phase_manoeuvre(s, start), found.solved, flown.best)
