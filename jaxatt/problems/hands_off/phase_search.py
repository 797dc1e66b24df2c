"""Search of one phase, with its path constraints, final time and first guess."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from jaxatt.problems.hands_off.pd_flight import flown_controls, fly_pd
from jaxatt.problems.hands_off.reading.valves import shortest_interval
from jaxatt.problems.hands_off.record import FinalTimes
from jaxatt.problems.hands_off.search.final_time import Timed, search_final_time
from jaxatt.problems.hands_off.search.limited_search import search_within_limits
from jaxatt.problems.hands_off.search.search import Found, search
from jaxatt.problems.hands_off.search.time_cost import Pricing
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

GUESSES = ("pulses", "pd", "l1")

Build = Callable[..., SparseTask]
"""(scenario, enforce_speed_limits, final_time) -> the task of a given phase."""


def search_phase(
    scenario: Scenario,
    build: Build,
    guess: str | Floats,
    inner: str,
    report: Report | None,
) -> tuple[SparseTask, Found, FinalTimes | None]:
    """Search a phase; return its task, the answer and the final times tried, if it is free.

    Path constraints are left out at first, see `limited_search`; so are they at other final times.
    """
    count, seed, horizon = scenario.solver.starts, scenario.solver.seed, scenario.horizon

    def attempt(final_time: float) -> tuple[SparseTask, Found]:
        task = build(scenario, enforce_speed_limits=False, final_time=final_time)
        task = task.sharing_programs()
        start = _guess(scenario, build, task, guess)
        limited = search_within_limits(task, count, seed, start, inner, report)
        return limited.task, limited.found

    def rebuild(task: SparseTask, final_time: float) -> SparseTask:
        again = build(scenario, enforce_speed_limits=False, final_time=final_time)
        again = again.sharing_programs()
        if isinstance(task, SlewTask) and isinstance(again, SlewTask):
            return again.enforcing(
                task.constraint_margin, task.form.speed_limited, task.speed_margin
            ).weaker(task.torque_margin)
        return again

    if not horizon.free:
        return *attempt(horizon.duration), None
    shortest = max(horizon.shortest, shortest_interval(scenario.vehicle) * horizon.intervals)
    pricing = Pricing(scenario.objective.time_weight, shortest, horizon.longest)
    timed = search_final_time(attempt, rebuild, pricing, count, seed, report)
    return timed.task, timed.found, _record(pricing, timed)


def _record(pricing: Pricing, timed: Timed) -> FinalTimes:
    trials = timed.trials
    return FinalTimes(
        time_weight=pricing.weight,
        cost=timed.cost,
        final_time=np.array([trial.final_time for trial in trials]),
        costs=np.array([trial.cost for trial in trials]),
        active_intervals=np.array([trial.active_intervals for trial in trials]),
        reached=np.array([trial.reached for trial in trials]),
        how=tuple(trial.how for trial in trials),
    )


def _guess(
    scenario: Scenario,
    build: Build,
    task: SparseTask,
    guess: str | Floats,
) -> Floats | None:
    if not isinstance(guess, str):
        controls = np.asarray(guess, float)
        if controls.shape != (task.intervals, task.size) or not np.isfinite(controls).all():
            raise ValueError(
                f"guess has shape {controls.shape}: expected finite controls of shape "
                f"({task.intervals}, {task.size})"
            )
        return controls
    if guess == "pulses":
        return None
    if guess == "pd" and isinstance(task, SlewTask):
        return flown_controls(task, fly_pd(task))
    if guess == "l1":
        l1 = replace(scenario, objective=replace(scenario.objective, kind="l1"))
        effort = build(l1, final_time=task.final_time)
        found = search(effort, min(8, scenario.solver.starts), scenario.solver.seed)
        return found.best.controls[0]
    raise ValueError(f"guess = {guess!r}: unknown here; choose one of {', '.join(GUESSES)}")
