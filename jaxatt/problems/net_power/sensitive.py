"""Answers to one phase as functions of what they depend on."""

from __future__ import annotations

from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.answers import Answers, flown_again, phase_manoeuvre
from jaxatt.problems.net_power.build import free_manoeuvre_of
from jaxatt.problems.net_power.magnetic.sensitive import sensitive_free_time
from jaxatt.problems.net_power.wheels.sensitive import sensitive_wheels
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.sensitive import SensitiveAnswer


def sensitive_manoeuvre(scenario: Scenario, start: PhaseStart, found: Answers) -> SensitiveAnswer:
    """The answer that a report shows, polished."""
    if found.free is not None:
        _check_reached(scenario, bool(found.free.reached[0]))
        return sensitive_free_time(scenario, lambda s: free_manoeuvre_of(s, start), found.free)
    if found.solved is None:
        raise ScenarioError(
            f"{scenario.name}: this task prescribes the attitude, so that nothing is decided; ask "
            "for the sensitivities of a harvest"
        )
    flown = flown_again(phase_manoeuvre(scenario, start), found.solved)
    _check_reached(scenario, bool(flown.reached[flown.best]))
    return sensitive_wheels(scenario, lambda s: phase_manoeuvre(s, start), found.solved, flown.best)


def _check_reached(scenario: Scenario, reached: bool) -> None:
    """Refuse an answer that misses a target which it has to reach."""
    if not reached and scenario.objective.terminal != "penalty":
        raise ScenarioError(
            f"{scenario.name}: no start reaches the target, so there is no answer to "
            "differentiate; give more starts, or more time"
        )
