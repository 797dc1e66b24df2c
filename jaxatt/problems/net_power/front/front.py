"""Fronts of net energy against time, or against the error at the end."""

from __future__ import annotations

from jaxatt.problems.front import Front, FrontRequest
from jaxatt.problems.net_power.build import options_of
from jaxatt.problems.net_power.front.error import error_front
from jaxatt.problems.net_power.front.free_time import free_time_front
from jaxatt.problems.net_power.front.time import time_front
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.chunks import Report


def net_power_front(scenario: Scenario, asked: FrontRequest, report: Report | None) -> Front:
    """Solve a manoeuvre for many final times, weights of time or weights of the error at once.

    Raises `ScenarioError` for plans, and where there is nothing to weigh.
    """
    if options_of(scenario).tasks:
        raise ScenarioError(
            f"{scenario.name}: is a plan, whose tasks have times and ends of their own; ask for "
            "the front of a single manoeuvre, with [target] and [horizon]"
        )
    free = scenario.horizon.free
    if asked.over == "time":
        return (free_time_front if free else time_front)(scenario, asked, report)
    if free:
        raise ScenarioError(
            f'{scenario.name}: [horizon] final_time = "free": energy is weighed against time '
            "there; ask for the front over time"
        )
    return error_front(scenario, asked, report)
