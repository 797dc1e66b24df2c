"""Searches from the flight of a PD law, where all that was found earns less than it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.baseline import PDBaseline, fly_baseline
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.wheels.rolled_out import rolled_out
from jaxatt.problems.net_power.wheels.solve import solve_in_fine_steps
from jaxatt.problems.net_power.wheels.task import wheels_task
from jaxatt.problems.net_power.wheels.within_limits import keeping_to
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report


def also_from_law(
    manoeuvres: Sequence[Manoeuvre],
    found: Sequence[Solved],
    law: PDBaseline,
    size: int | None = None,
    room: int = 1,
    report: Report | None = None,
) -> tuple[Solved, ...]:
    """The answers found, and one more where the best of them earns less than the law beside it.

    size : intervals of the programme, and room : its manoeuvres, both as in the search before, so
    that nothing is compiled again.
    """
    flown = fly_baseline(manoeuvres, law)
    answers = []
    for k, (manoeuvre, solved) in enumerate(zip(manoeuvres, found, strict=True)):
        if _most(solved) < flown.energy.net_J[k]:
            torque = held_torque(flown.wheel_torque[k], manoeuvre.intervals)
            solved = solved.joined(_from(torque, manoeuvre, solved, size, room, report))
        answers.append(replace(solved, law=flown) if len(manoeuvres) == 1 else solved)
    return tuple(answers)


def _most(solved: Solved) -> float:
    """Most energy [J] that an answer claims which obeys the programme; -inf where none does."""
    content = np.isin(solved.status, (Status.CONVERGED, Status.FEASIBLE))
    return float(np.max(solved.claimed, where=content, initial=-np.inf))


def _from(
    torque: Floats,
    manoeuvre: Manoeuvre,
    solved: Solved,
    size: int | None,
    room: int,
    report: Report | None,
) -> Solved:
    """Answer from torques (N, n) [N m] as one start, within the limits of those that there are."""
    if solved.limits is not None:
        manoeuvre = keeping_to(manoeuvre, solved.limits)
    task = wheels_task(manoeuvre, solved.substeps, size)
    start = rolled_out(task, torque[None])
    rows = rows_of_stages(len(solved.status) * room, start.u.shape[1])
    told = None if report is None else _from_law(report)
    _, (answer,) = solve_in_fine_steps([task], [start], told, rows, room, least=solved.substeps)
    return answer


def held_torque(torque: Floats, intervals: int) -> Floats:
    """Means (N, n) over N equal intervals of a torque (M, n) that is held over M others."""
    before, after = (np.linspace(0.0, 1.0, count + 1) for count in (len(torque), intervals))
    impulse = np.concatenate([np.zeros((1, torque.shape[1])), np.cumsum(torque, axis=0)])
    passed = np.stack([np.interp(after, before, each) for each in impulse.T], axis=1)
    means: Floats = np.diff(passed, axis=0) * (intervals / len(torque))
    return means


def _from_law(report: Report) -> Report:
    return lambda stage, done: report(f"{stage}, from the PD law's flight", done)
