"""Solve manoeuvres with wheels from given starts, in as many Runge-Kutta steps as they need."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.judge import judge_manoeuvre
from jaxatt.problems.net_power.wheels.batch import solve_starts
from jaxatt.problems.net_power.wheels.starts import Starts
from jaxatt.problems.net_power.wheels.task import WheelsTask, wheels_task
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

_MOST_SUBSTEPS = 8
_FLOWN = 4
"""Answers, the best of each manoeuvre, that are flown to see whether the steps are fine enough."""
_LONGEST_TURN = 0.25
"""[rad], in one step."""
_FEW = 0.5
"""Share of them that must end where the solver says."""


def solve_in_fine_steps(
    tasks: Sequence[WheelsTask],
    parts: Sequence[Starts],
    report: Report | None = None,
    rows: int | None = None,
    room: int = 1,
    settings: InteriorSettings | None = None,
    least: int = 1,
) -> tuple[Sequence[WheelsTask], tuple[Solved, ...]]:
    """Solve tasks of one form from given starts, with as many steps an interval as they ask for.

    parts : starts of each task.  rows : starts in one compiled call.  room : see `search_wheels`.
    settings : of the solver; None for those of the form.  least : see `in_steps`.

    Where the best answers do not end where the solver says when they are flown finely, all are
    solved again with more Runge-Kutta steps an interval, from where they are.
    Returns the tasks with those steps, and the answers.
    """
    tasks, starts = in_steps(tasks, parts, least), _together(parts)
    solution = solve_starts(tasks, starts, settings, report, rows, room)
    found = _solved(tasks, starts, solution)
    substeps = tasks[0].form.substeps
    while substeps < _MOST_SUBSTEPS and _too_coarse(tasks, found):
        substeps *= 2
        tasks = _with_substeps(tasks, substeps)
        starts = continued(starts, solution)
        solution = solve_starts(tasks, starts, settings, report, rows, room)
        found = _solved(tasks, starts, solution)
    return tasks, found


def solve_wheels(
    tasks: Sequence[WheelsTask],
    parts: Sequence[Starts],
    report: Report | None = None,
    rows: int | None = None,
    room: int = 1,
) -> tuple[Solved, ...]:
    """Solve tasks with the steps that they have from given starts, e.g. neighbours' answers."""
    starts = _together(parts)
    return _solved(tasks, starts, solve_starts(tasks, starts, None, report, rows, room))


def in_steps(
    tasks: Sequence[WheelsTask], parts: Sequence[Starts], least: int = 1
) -> Sequence[WheelsTask]:
    """Tasks in as many Runge-Kutta steps an interval as the turns of their starts ask for.

    least : steps, at least: tasks that have the same number share a compiled program.  Those of
    manoeuvres that say how many stay as they are.
    """
    if tasks[0].manoeuvre.substeps is not None:
        return tasks
    return _with_substeps(tasks, max(least, *map(_substeps, parts), 1))


def continued(starts: Starts, solution: InteriorSolution) -> Starts:
    """Starts from where a solve ended, or from where it began where that is not finite."""
    u, x = np.asarray(solution.u), np.asarray(solution.x)
    finite = (np.isfinite(u).all(axis=(1, 2)) & np.isfinite(x).all(axis=(1, 2)))[:, None, None]
    return starts._replace(u=np.where(finite, u, starts.u), x=np.where(finite, x, starts.x))


def _together(parts: Sequence[Starts]) -> Starts:
    """Starts of all manoeuvres, each with its number."""
    numbered = [
        part._replace(task=np.full(len(part.u), number, int)) for number, part in enumerate(parts)
    ]
    return Starts(*(np.concatenate(leaves) for leaves in zip(*numbered, strict=True)))


def _with_substeps(tasks: Sequence[WheelsTask], substeps: int) -> Sequence[WheelsTask]:
    """The tasks with so many Runge-Kutta steps an interval."""
    if tasks[0].form.substeps == substeps:
        return tasks
    size = len(tasks[0].parameters.stages.step)
    return [wheels_task(task.manoeuvre, substeps, size, task.held) for task in tasks]


def _substeps(starts: Starts) -> int:
    """Runge-Kutta steps an interval that the turns of the starts ask for, a power of two."""
    q = np.asarray(starts.x)[..., :4]
    alike = np.clip(np.abs((q[:, 1:] * q[:, :-1]).sum(axis=-1)), 0.0, 1.0)
    turned = float(2.0 * np.arccos(alike).max(initial=0.0))
    asked = max(1, math.ceil(turned / _LONGEST_TURN))
    return min(_MOST_SUBSTEPS, 1 << (asked - 1).bit_length())


def _too_coarse(tasks: Sequence[WheelsTask], found: Sequence[Solved]) -> bool:
    """Whether answers that the solver is content with do not arrive in flight."""
    manoeuvres = [task.manoeuvre for task in tasks]
    if manoeuvres[0].end is None or manoeuvres[0].terminal == "penalty":
        return False
    arrived: list[bool] = []
    most = max(1, _FLOWN // len(manoeuvres))
    # Those of the longest intervals first: they are the coarsest.
    coarsest = sorted(zip(manoeuvres, found, strict=True), key=lambda pair: -pair[0].step)
    for manoeuvre, solved in coarsest:
        content = np.flatnonzero(np.isin(solved.status, (Status.CONVERGED, Status.FEASIBLE)))
        best = content[np.argsort(-solved.claimed[content])][:most]
        if len(best):
            chosen = solved.pick(best)
            verdict = judge_manoeuvre(manoeuvre, chosen.torque, chosen.dipole)
            arrived += verdict.arrives.tolist()
        if len(arrived) >= _FLOWN:
            break
    return bool(arrived) and float(np.mean(arrived)) < _FEW


def _solved(
    tasks: Sequence[WheelsTask], starts: Starts, solution: InteriorSolution
) -> tuple[Solved, ...]:
    """Answers to each manoeuvre in SI units, without the intervals that only fill up."""
    of = np.asarray(starts.task)
    first = tasks[0]
    count, form, p = len(first.held), first.form, first.parameters
    finite = np.isfinite(solution.u).all(axis=(1, 2))
    u = np.nan_to_num(np.asarray(solution.u))[:, :count]
    dipole: Floats | None = None
    if form.dipoles:
        parts = u[..., -form.dipoles :] * np.tile(np.asarray(p.dipole_limit), 2)
        dipole = parts[..., :3] - parts[..., 3:]
    scaled = u[..., : form.wheels]
    # The solver also pays a small price of effort, which is none of the energy.
    step = np.stack([np.asarray(task.parameters.stages.paid)[:count] for task in tasks])
    paid = float(p.effort) * (step[of] * (scaled**2).sum(axis=2)).sum(axis=1)
    loads = np.array([float(task.parameters.load) * task.manoeuvre.duration for task in tasks])
    scale = np.array([float(task.parameters.energy_scale) for task in tasks])
    whole = Solved(
        torque=np.repeat(scaled * np.asarray(p.torque_limit), first.held, axis=1),
        dipole=None if dipole is None else np.repeat(dipole, first.held, axis=1),
        claimed=paid - np.asarray(solution.objective) * scale[of] - loads[of],
        status=np.where(finite, solution.status, int(Status.NOT_FINITE)),
        violation=np.asarray(solution.violation),
        stationarity=np.asarray(solution.stationarity),
        iterations=np.asarray(solution.iterations),
        substeps=form.substeps,
    )
    return tuple(
        replace(whole.pick(np.flatnonzero(of == number)), limits=task.manoeuvre.limits)
        for number, task in enumerate(tasks)
    )
