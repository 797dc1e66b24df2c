"""Search from many starts for the manoeuvre with wheels that earns the most."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from jaxatt.optimize.interior_point.solver import InteriorSolution
from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.judge import judge_manoeuvre
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.wheels.batch import solve_starts
from jaxatt.problems.net_power.wheels.lengths import shared_length
from jaxatt.problems.net_power.wheels.starts import Starts, draw_all
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


def search_wheels(
    manoeuvres: Sequence[Manoeuvre],
    count: int,
    seed: int,
    report: Report | None = None,
    shared: bool = False,
    room: int = 1,
) -> tuple[Solved, ...]:
    """Solve from `count` starts each, for several manoeuvres of one shape in one batch.

    manoeuvres : of one number of intervals, one kind of satellite and one kind of end.
    shared : whether to fill their intervals up to a length that other manoeuvres have, too, so that
    they share a compiled program.
    room : manoeuvres that the program has room for, at least; so that it serves fewer, too.

    Where the best answers do not end where the solver says when they are flown finely, all are
    solved again with more Runge-Kutta steps an interval, from where they are.
    """
    size = shared_length(manoeuvres[0].intervals) if shared else None
    tasks = [wheels_task(manoeuvre, None, size) for manoeuvre in manoeuvres]
    return solve_in_fine_steps(tasks, draw_all(tasks, count, seed), report, room=room)[1]


def solve_in_fine_steps(
    tasks: Sequence[WheelsTask],
    parts: Sequence[Starts],
    report: Report | None = None,
    rows: int | None = None,
    room: int = 1,
) -> tuple[Sequence[WheelsTask], tuple[Solved, ...]]:
    """Solve tasks of one form from given starts, with as many steps an interval as they ask for.

    parts : starts of each task.  rows : starts in one compiled call.  room : see `search_wheels`.
    Returns the tasks with those steps, and the answers; see `search_wheels`.
    """
    manoeuvres, starts = [task.manoeuvre for task in tasks], _together(parts)
    size = starts.u.shape[1]
    if manoeuvres[0].substeps is None:
        steps = _substeps(starts)
        tasks = [wheels_task(manoeuvre, steps, size) for manoeuvre in manoeuvres]
    solution = solve_starts(tasks, starts, report=report, rows=rows, room=room)
    found = _solved(tasks, starts, solution)
    substeps = tasks[0].form.substeps
    while substeps < _MOST_SUBSTEPS and _too_coarse(manoeuvres, found):
        substeps *= 2
        tasks = [wheels_task(manoeuvre, substeps, size) for manoeuvre in manoeuvres]
        starts = continued(starts, solution)
        solution = solve_starts(tasks, starts, report=report, rows=rows, room=room)
        found = _solved(tasks, starts, solution)
    return tasks, found


def solve_wheels(
    tasks: Sequence[WheelsTask],
    parts: Sequence[Starts],
    report: Report | None = None,
    rows: int | None = None,
) -> tuple[Solved, ...]:
    """Solve tasks with the steps that they have from given starts, e.g. neighbours' answers."""
    starts = _together(parts)
    return _solved(tasks, starts, solve_starts(tasks, starts, report=report, rows=rows))


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


def _substeps(starts: Starts) -> int:
    """Runge-Kutta steps an interval that the turns of the starts ask for, a power of two."""
    q = np.asarray(starts.x)[..., :4]
    alike = np.clip(np.abs((q[:, 1:] * q[:, :-1]).sum(axis=-1)), 0.0, 1.0)
    turned = float(2.0 * np.arccos(alike).max(initial=0.0))
    asked = max(1, math.ceil(turned / _LONGEST_TURN))
    return min(_MOST_SUBSTEPS, 1 << (asked - 1).bit_length())


def _too_coarse(manoeuvres: Sequence[Manoeuvre], found: Sequence[Solved]) -> bool:
    """Whether answers that the solver is content with do not arrive in flight."""
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
    count, form, p = first.manoeuvre.intervals, first.form, first.parameters
    finite = np.isfinite(solution.u).all(axis=(1, 2))
    u = np.nan_to_num(np.asarray(solution.u))[:, :count]
    dipole: Floats | None = None
    if form.dipoles:
        parts = u[..., -form.dipoles :] * np.tile(np.asarray(p.dipole_limit), 2)
        dipole = parts[..., :3] - parts[..., 3:]
    scaled = u[..., : form.wheels]
    # The solver also pays a small price of effort, which is none of the energy.
    step = np.array([task.manoeuvre.step for task in tasks])
    paid = step[of] * float(p.effort) * (scaled**2).sum(axis=(1, 2))
    loads = np.array([task.manoeuvre.load * task.manoeuvre.duration for task in tasks])
    scale = np.array([float(task.parameters.energy_scale) for task in tasks])
    whole = Solved(
        torque=scaled * np.asarray(p.torque_limit),
        dipole=dipole,
        claimed=paid - np.asarray(solution.objective) * scale[of] - loads[of],
        status=np.where(finite, solution.status, int(Status.NOT_FINITE)),
        violation=np.asarray(solution.violation),
        stationarity=np.asarray(solution.stationarity),
        iterations=np.asarray(solution.iterations),
    )
    return tuple(whole.pick(np.flatnonzero(of == number)) for number in range(len(tasks)))
