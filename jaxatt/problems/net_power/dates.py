"""One plan on many dates: all dates of a task in one batch, task after task."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jaxatt.environment.epoch import moment_text
from jaxatt.optimize.status import Status
from jaxatt.problems.failure_reason import failure_reason
from jaxatt.problems.family import PhaseStart
from jaxatt.problems.net_power.baseline import PDBaseline, fly_baseline
from jaxatt.problems.net_power.broken_margins import broken_margins
from jaxatt.problems.net_power.build import beginning, options_of
from jaxatt.problems.net_power.corrected import corrected
from jaxatt.problems.net_power.flight import PoweredFlight, fly_many
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.judge import judge_flight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Motion, Satellite
from jaxatt.problems.net_power.plan.hold import fly_held
from jaxatt.problems.net_power.plan.manoeuvre import Terms, held_rate, task_manoeuvre
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.reading.scenario import read_along
from jaxatt.problems.net_power.wheels.search import search_wheels
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.orbit import on_date
from jaxatt.problems.scenario import Orbit, Scenario
from jaxatt.problems.verdict import Verdict
from jaxatt.runtime.arrays import Flags, Floats
from jaxatt.runtime.chunks import Report

_AT_ONCE = 64
"""Dates that go through a task together, which bounds the memory of a year."""
_TRIES = 3
"""Answers of a date that are flown, the best by the solver's count first, until one reaches; one
that just misses is corrected first."""


@dataclass(frozen=True, eq=False)
class DatedPlan:
    """A plan on D dates, of T tasks.

    days : (D,), epochs since J2000.  orbits : from then on; None where none is known.
    net, baseline : (D, T) [J], by the flights; not a number after a task that was not flown as
    asked.  least_charge : (D,) [J], until then.
    reason : why a date's plan cannot be flown, and which task; empty where it can.
    """

    days: Floats
    orbits: tuple[Orbit | None, ...]
    net: Floats
    baseline: Floats
    least_charge: Floats
    reason: tuple[str, ...]

    @property
    def reached(self) -> Flags:
        """Dates on which every task is flown as asked, (D,)."""
        return np.array([not reason for reason in self.reason], bool)


@dataclass(eq=False)
class _Dates:
    """Dates under way: where each stands after the last task, and what it has earned."""

    orbits: list[Orbit | None]
    satellites: list[Satellite | None]
    tasks: list[tuple[Task, ...]]
    motion: list[Motion]
    charge: Floats
    net: Floats
    baseline: Floats
    least: Floats
    reason: list[str]

    @property
    def going(self) -> list[int]:
        """Dates whose plans go on."""
        return [k for k, reason in enumerate(self.reason) if not reason]


def plan_on_dates(
    scenario: Scenario, days: Floats, starts: int, seed: int, report: Report | None
) -> DatedPlan:
    """Solve the plan of a scenario on other dates, each in sequence from its own flown ends.

    Sun, shadow, magnetic field and the directions that attitudes are told by are those of the
    dates.  An orbit goes on until then as far as it is known, see `on_date`; so places that have to
    be in sight are not looked for.
    days : (D,), epochs since J2000.  starts : of every harvest on every date.
    """
    parts = []
    for first in range(0, len(days), _AT_ONCE):
        some = days[first : first + _AT_ONCE]
        name = f"dates {first + 1} to {first + len(some)} of {len(days)}"
        room = min(_AT_ONCE, len(days))
        parts.append(_plan_on_some(scenario, some, starts, seed, room, _named(report, name)))
    return DatedPlan(
        days,
        tuple(orbit for part in parts for orbit in part.orbits),
        np.concatenate([part.net for part in parts]),
        np.concatenate([part.baseline for part in parts]),
        np.concatenate([part.least for part in parts]),
        tuple(reason for part in parts for reason in part.reason),
    )


def _plan_on_some(
    scenario: Scenario, days: Floats, starts: int, seed: int, room: int, report: Report | None
) -> _Dates:
    """Solve the plan on so many dates as go through a task together.

    room : of the compiled programmes, so that they serve the dates that are left after others
    failed, and the last of the year, too.
    """
    options, tasks, count = options_of(scenario), options_of(scenario).tasks, len(days)
    begun = beginning(scenario, PhaseStart())
    dates = _Dates(
        [None] * count,
        [None] * count,
        [tasks] * count,
        [begun[0]] * count,
        np.full(count, begun[1]),
        np.full((count, len(tasks)), np.nan),
        np.full((count, len(tasks)), np.nan),
        np.full(count, begun[1]),
        [""] * count,
    )
    _set_out(scenario, days, dates)
    for index, task in enumerate(tasks):
        rows = dates.going
        if not rows:
            break
        manoeuvres = [_manoeuvre(scenario, dates, index, k) for k in rows]
        stage = _named(report, f"task {index + 1} of {len(tasks)}, {task.name}")
        if task.searched:
            law = options.baseline
            flight, verdict = _harvests(manoeuvres, starts, seed, stage, room, law)
            base = flight if law is None else fly_baseline(manoeuvres, law)
        else:
            flight = fly_held(
                manoeuvres, np.stack([held_rate(dates.tasks[k][index]) for k in rows])
            )
            verdict, base = _judged(manoeuvres, flight), flight
        _note(dates, rows, index, task, manoeuvres, flight, verdict, base)
    return dates


def _set_out(scenario: Scenario, days: Floats, dates: _Dates) -> None:
    """Read the plan on each date: its orbit, satellite, tasks and beginning, or why it has none."""
    if scenario.orbit is None:
        raise ScenarioError(f"{scenario.origin}: [orbit]: missing, and dates need one; add it")
    document, orbit = _undated(scenario), scenario.orbit
    satellite = options_of(scenario).satellite
    for k, day in enumerate(days.tolist()):
        try:
            orbit = on_date(orbit, document["orbit"], scenario.origin, scenario.folder, [], day)
            dates.orbits[k] = orbit
            document["orbit"]["epoch"] = moment_text(day)
            dated = read_along(
                copy.deepcopy(document), scenario.origin, scenario.folder, orbit, Faults()
            )
        except ValueError as error:
            dates.reason[k] = str(error)
            continue
        options = options_of(dated)
        found = options.satellite
        dates.satellites[k] = replace(satellite, orbit=found.orbit, light=found.light)
        dates.tasks[k] = options.tasks
        dates.motion[k], _ = beginning(dated, PhaseStart())


def _undated(scenario: Scenario) -> dict[str, Any]:
    """The plan's document with its tasks by seconds, the true sun, and no places to be seen."""
    document = copy.deepcopy(dict(scenario.document))
    for key in ("sun_inertial", "sun_distance_m"):
        document.get("light", {}).pop(key, None)
    for table, task in zip(document["tasks"], options_of(scenario).tasks, strict=True):
        for key in ("start", "end", "duration_s", "target_deg"):
            table.pop(key, None)
        table.update(start_s=task.start, end_s=task.end)
    return document


def _manoeuvre(scenario: Scenario, dates: _Dates, index: int, k: int) -> Manoeuvre:
    options, satellite = options_of(scenario), dates.satellites[k]
    assert satellite is not None
    terms = Terms(
        scenario.objective.terminal,
        options.weights.attitude,
        options.weights.rate,
        scenario.horizon.substeps,
        options.floor,
    )
    return task_manoeuvre(
        satellite, dates.tasks[k], index, dates.motion[k], float(dates.charge[k]), terms
    )


def _harvests(
    manoeuvres: Sequence[Manoeuvre],
    starts: int,
    seed: int,
    report: Report | None,
    room: int,
    law: PDBaseline | None,
) -> tuple[PoweredFlight, Verdict]:
    """Search a harvest on all dates, and fly the best answer of each that reaches."""
    solved = search_wheels(manoeuvres, starts, seed, report, shared=True, room=room, law=law)
    ranks = [_ranked(answers) for answers in solved]
    chosen = [0] * len(manoeuvres)
    for attempt in range(min(_TRIES, min(len(rank) for rank in ranks))):
        torque = np.stack([s.torque[r[c]] for s, r, c in zip(solved, ranks, chosen, strict=True)])
        dipole = None
        if solved[0].dipole is not None:
            dipole = np.stack(
                [
                    s.dipole[r[c]]
                    for s, r, c in zip(solved, ranks, chosen, strict=True)
                    if s.dipole is not None
                ]
            )
        flight, verdict = _flown(manoeuvres, torque, dipole)
        if not verdict.reached.all():
            for k in np.flatnonzero(~verdict.reached).tolist():
                held = None if dipole is None else dipole[k]
                torque[k] = corrected(manoeuvres[k], torque[k], held)
            flight, verdict = _flown(manoeuvres, torque, dipole)
        if verdict.reached.all() or attempt + 1 == _TRIES:
            break
        last = attempt + 1
        chosen = [c if ok else last for c, ok in zip(chosen, verdict.reached, strict=True)]
    return flight, verdict


def _flown(
    manoeuvres: Sequence[Manoeuvre], torque: Floats, dipole: Floats | None
) -> tuple[PoweredFlight, Verdict]:
    """Fly one answer to each manoeuvre, and judge it."""
    flight = fly_many(manoeuvres, np.arange(len(manoeuvres)), torque, dipole)
    return flight, _judged(manoeuvres, flight, dipole is not None)


def _judged(
    manoeuvres: Sequence[Manoeuvre], flight: PoweredFlight, decided_dipole: bool = False
) -> Verdict:
    """Judge each flight by its own manoeuvre: a place on the ground moves with the date."""
    return Verdict.join(
        [
            judge_flight(manoeuvre, flight, decided_dipole).pick(np.array([k]))
            for k, manoeuvre in enumerate(manoeuvres)
        ]
    )


def _ranked(solved: Solved) -> list[int]:
    """Starts in the order in which they are flown: converged, then by the energy claimed."""
    failed = ~np.isin(solved.status, [int(Status.CONVERGED), int(Status.FEASIBLE)])
    order = np.lexsort((-np.nan_to_num(solved.claimed, nan=-np.inf), failed))
    return [int(k) for k in order]


def _note(
    dates: _Dates,
    rows: Sequence[int],
    index: int,
    task: Task,
    manoeuvres: Sequence[Manoeuvre],
    flight: PoweredFlight,
    verdict: Verdict,
    base: PoweredFlight,
) -> None:
    """Note what the dates in `rows` earned in a task, and where it left them."""
    for place, k in enumerate(rows):
        dates.least[k] = min(dates.least[k], float(flight.energy.least_charge[place]))
        if not verdict.reached[place]:
            why = failure_reason(
                verdict.pick(np.array([place])),
                Status.CONVERGED,
                broken_margins=broken_margins(manoeuvres[place], flight, place),
            )
            dates.reason[k] = f'task {index + 1} "{task.name}": {why}'
            continue
        dates.net[k, index] = flight.energy.net_J[place]
        dates.baseline[k, index] = base.energy.net_J[place]
        ends = (flight.q_ib, flight.omega_ib, flight.omega_bw)
        dates.motion[k] = Motion(*(part[place, -1] for part in ends))
        dates.charge[k] = flight.energy.charge[place, -1]


def _named(report: Report | None, name: str) -> Report | None:
    if report is None:
        return None
    return lambda stage, done: report(f"{stage}; {name}", done)
