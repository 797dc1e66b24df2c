"""Search, flight and judgement of one phase: a manoeuvre, or a task of a plan."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.net_power.baseline import fly_baseline
from jaxatt.problems.net_power.build import (
    beginning,
    carried_on,
    free_manoeuvre_of,
    manoeuvre_of,
    options_of,
)
from jaxatt.problems.net_power.flight import fly
from jaxatt.problems.net_power.found import Flown, Solved, ranked
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.net_power.magnetic.judge import fly_found
from jaxatt.problems.net_power.magnetic.search import FrontFound, search_magnetic
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.phase import phase_of
from jaxatt.problems.net_power.plan.hold import fly_held
from jaxatt.problems.net_power.plan.judge import judge_held
from jaxatt.problems.net_power.plan.manoeuvre import Terms, held_rate, task_manoeuvre
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.printed_cost import printed_cost
from jaxatt.problems.net_power.record import NetPower
from jaxatt.problems.net_power.wheels.search import search_wheels
from jaxatt.problems.scenario import Scenario
from jaxatt.records.phase import Phase
from jaxatt.runtime.chunks import Report


@dataclass(frozen=True, eq=False)
class Answers:
    """Answers to one phase.

    solved : None where a task prescribes the attitude, or where the final time is free.
    free : of a manoeuvre in free time.
    """

    solved: Solved | None
    free: FrontFound | None = None


def task_of(scenario: Scenario, start: PhaseStart) -> Task | None:
    """Task of a plan that a phase flies; None for a single manoeuvre."""
    tasks = options_of(scenario).tasks
    return tasks[start.index] if tasks else None


def phase_manoeuvre(scenario: Scenario, start: PhaseStart) -> Manoeuvre:
    """Manoeuvre of a phase from where the one before ended."""
    options = options_of(scenario)
    if not options.tasks:
        return manoeuvre_of(scenario, start)
    motion, charge = beginning(scenario, start)
    terms = Terms(
        scenario.objective.terminal,
        options.weights.attitude,
        options.weights.rate,
        scenario.horizon.substeps,
        options.floor,
    )
    return task_manoeuvre(options.satellite, options.tasks, start.index, motion, charge, terms)


def searched(scenario: Scenario, start: PhaseStart, report: Report | None) -> Answers:
    """Solve a phase from many starts, where there is anything to decide."""
    task = task_of(scenario, start)
    if task is not None and not task.searched:
        return Answers(None)
    solver = scenario.solver
    if scenario.horizon.free:
        return Answers(
            None,
            search_magnetic(free_manoeuvre_of(scenario, start), solver.starts, solver.seed, report),
        )
    manoeuvre = phase_manoeuvre(scenario, start)
    named = report if task is None or report is None else _named(report, task.name)
    (solved,) = search_wheels(
        [manoeuvre],
        solver.starts,
        solver.seed,
        named,
        shared=task is not None,
        law=options_of(scenario).baseline,
    )
    return Answers(solved)


def judged(scenario: Scenario, start: PhaseStart, found: Answers) -> tuple[Phase, InitialState]:
    """Fly the answers of a phase finely; return the best one's record and where it ended."""
    family = scenario.family
    if found.free is not None:
        flown = fly_found(found.free)
        phase, end = phase_of(flown, family, None, free_time=True)
        return phase, carried_on(end, float(flown.flight.energy.charge[flown.best, -1]))
    task, manoeuvre = task_of(scenario, start), phase_manoeuvre(scenario, start)
    law = options_of(scenario).baseline
    if found.solved is None:
        assert task is not None
        flown = held(task, manoeuvre)
        baseline = flown.flight if law is not None else None
    else:
        flown = flown_again(manoeuvre, found.solved)
        baseline = found.solved.law
        if baseline is None and law is not None:
            baseline = fly_baseline([manoeuvre], law)
    phase, end = phase_of(flown, family, baseline)
    if task is not None:
        phase = replace(phase, section=_of_task(phase, task))
    return phase, carried_on(end, float(flown.flight.energy.charge[flown.best, -1]))


def flown_again(manoeuvre: Manoeuvre, solved: Solved) -> Flown:
    """Fly and judge the answers of a solver, and choose the best."""
    flight = fly(manoeuvre, solved.torque, solved.dipole)
    verdict = judge_flight(manoeuvre, flight, solved.dipole is not None)
    score = flight.energy.net_J - printed_cost(manoeuvre, flight)
    weighed = manoeuvre.terminal == "penalty"
    return ranked(manoeuvre, solved, flight, verdict, score, flight.energy.turnover, weighed)


def held(task: Task, manoeuvre: Manoeuvre) -> Flown:
    """Fly and judge a task that prescribes the attitude."""
    flight = fly_held([manoeuvre], held_rate(task)[None])
    verdict = judge_held(task, manoeuvre, flight)
    one, nothing = flight.energy.net_J, np.zeros(1)
    solved = Solved(
        torque=flight.wheel_torque,
        dipole=None,
        claimed=one,
        status=np.array([int(Status.CONVERGED)]),
        violation=nothing,
        stationarity=nothing,
        iterations=np.zeros(1, int),
    )
    return ranked(manoeuvre, solved, flight, verdict, one, 1.0)


def _of_task(phase: Phase, task: Task) -> NetPower:
    assert isinstance(phase.section, NetPower)
    site = task.site
    place = None if site is None else np.degrees([site.latitude, site.longitude])
    return replace(phase.section, task=task.name, mode=task.mode, site=place)


def _named(report: Report, name: str) -> Report:
    return lambda stage, done: report(f"{stage} ({name})", done)
