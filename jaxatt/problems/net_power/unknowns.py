"""The largest manoeuvres whose answers are tested for regularity."""

from __future__ import annotations

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario

_MOST_UNKNOWNS = 2000
"""Controls of all intervals, up to which matrices of their number squared are handy."""


def check_unknowns(scenario: Scenario, intervals: int, controls: int) -> None:
    """Refuse manoeuvres whose test of regularity would take too large matrices.

    controls : of an interval.
    """
    unknowns = intervals * controls
    if unknowns > _MOST_UNKNOWNS:
        raise ScenarioError(
            f"{scenario.name}: {intervals} intervals of {controls} unknowns each are {unknowns}, "
            f"and sensitivities are for {_MOST_UNKNOWNS} at most; give at most "
            f"{_MOST_UNKNOWNS // controls} intervals"
        )
