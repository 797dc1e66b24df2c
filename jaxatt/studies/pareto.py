"""Pareto front of a scenario: what is gained against time, or against the error at the end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from jaxatt import scenarios
from jaxatt.problems.family import SearchOptions
from jaxatt.problems.front import FrontRequest
from jaxatt.problems.registry import family_of
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.settings import check_precision
from jaxatt.studies.pareto_front import ParetoFront

OVER = ("time", "error")
POINTS = 9
STARTS = 16
"""Starts of each point, unless others are asked for or the scenario has fewer."""


def pareto(
    scenario: scenarios.Scenario | str | Path,
    over: str = "time",
    *,
    points: int | None = None,
    values: Iterable[float] | None = None,
    starts: int | None = None,
    seed: int | None = None,
    report: Report | None = None,
) -> ParetoFront:
    """Solve a manoeuvre for many values of what its gain is weighed against, all in one batch.

    over : "time" or "error".
    points : number of values, `POINTS` by default, which the family then chooses.
    values : these values themselves: final times [s] over time, or weights of time where the
    scenario's final time is free; weights of the attitude [J] over error.
    starts : of each point, `STARTS` by default.  seed : by default the scenario's.
    report : called by the host with (stage, starts ended) between chunks of work.

    Raises `ScenarioError` where the scenario has no such front or a value makes no sense.
    """
    check_precision()
    if not isinstance(scenario, scenarios.Scenario):
        scenario = scenarios.load(scenario)
    asked = front_request(over, points, values)
    solver = scenario.solver
    count = min(STARTS, solver.starts) if starts is None else starts
    chosen = solver.seed if seed is None else seed
    if count < 1 or chosen < 0:
        raise scenarios.ScenarioError(
            f"starts = {count}, seed = {chosen}: give at least one start, and no negative seed"
        )
    scenario = replace(scenario, solver=scenarios.SolverSettings(count, chosen))
    family = family_of(scenario)
    family.check(scenario, SearchOptions())
    return ParetoFront(scenario, over, family.front(scenario, asked, report))


def front_request(over: str, points: int | None, values: Iterable[float] | None) -> FrontRequest:
    """Check what a front is asked for."""
    if over not in OVER:
        raise scenarios.ScenarioError(f'over = {over!r}: choose "time" or "error"')
    if values is not None and points is not None:
        raise scenarios.ScenarioError("points, values: give one of the two, not both")
    if values is not None:
        given = _values(values)
        return FrontRequest(over, len(given), given)
    number = POINTS if points is None else points
    if number < 2:
        raise scenarios.ScenarioError(f"points = {number}: a front needs at least two")
    return FrontRequest(over, number)


def _values(values: Iterable[float]) -> Floats:
    given = np.unique(np.asarray(list(values), float))
    if not np.isfinite(given).all() or (given <= 0.0).any():
        raise scenarios.ScenarioError(
            f"values = {given.tolist()}: all of them must be positive and finite"
        )
    if len(given) < 2:
        raise scenarios.ScenarioError(
            f"values = {given.tolist()}: a front needs at least two different ones"
        )
    return given
