"""Search from many starts for the manoeuvre with wheels that earns the most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.net_power.baseline import PDBaseline
from jaxatt.problems.net_power.found import Solved
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.wheels.batch import settings_for
from jaxatt.problems.net_power.wheels.from_law import also_from_law
from jaxatt.problems.net_power.wheels.longer import averaged, longer_intervals
from jaxatt.problems.net_power.wheels.rolled_out import rolled_out
from jaxatt.problems.net_power.wheels.solve import in_steps, solve_in_fine_steps, solve_wheels
from jaxatt.problems.net_power.wheels.starts import Starts, draw_all, filled
from jaxatt.problems.net_power.wheels.task import WheelsTask, wheels_task
from jaxatt.problems.net_power.wheels.within_limits import within_limits
from jaxatt.runtime.arrays import Counts
from jaxatt.runtime.chunks import Report
from jaxatt.runtime.lengths import shared_length

_LONG, _FIRST = 512, 256
"""Intervals from which a manoeuvre is searched on longer ones first, and how many of these."""
_REFINED = 4
"""Answers of the first search, the best of each manoeuvre, that are solved on its own intervals."""
_APART = 1e-5
"""Difference of two answers, as a share of the energy, from which both are worth refining."""
_BARRIER, _PASSES = 1e-4, 40
"""First barrier and most passes from an answer of the first search."""
_SHARED_STEPS = 4
"""Runge-Kutta steps an interval of manoeuvres that share a compiled program: those that need fewer
lose less by them than by a program of their own."""


def search_wheels(
    manoeuvres: Sequence[Manoeuvre],
    count: int,
    seed: int,
    report: Report | None = None,
    shared: bool = False,
    room: int = 1,
    law: PDBaseline | None = None,
) -> tuple[Solved, ...]:
    """Solve from `count` starts each, for several manoeuvres of one shape in one batch.

    manoeuvres : of one number of intervals, one kind of satellite and one kind of end.
    shared : whether to fill their intervals up to a length that other manoeuvres have, too, so that
    they share a compiled program.
    room : manoeuvres that the program has room for, at least; so that it serves fewer, too.
    law : whose flight is one start more wherever it earns more than the best answer.

    Long manoeuvres are solved from all starts on longer intervals, and the best few answers then on
    their own.  Wheels and their motors are kept within their limits.
    """
    room = max(room, len(manoeuvres))
    found = within_limits(
        manoeuvres, lambda some: _searched(some, count, seed, report, shared, room)
    )
    if law is None:
        return found
    size = shared_length(manoeuvres[0].intervals) if shared else None
    return also_from_law(manoeuvres, found, law, size, room, report)


def _searched(
    manoeuvres: Sequence[Manoeuvre],
    count: int,
    seed: int,
    report: Report | None,
    shared: bool,
    room: int,
) -> tuple[Solved, ...]:
    intervals = manoeuvres[0].intervals
    size = shared_length(intervals) if shared else None
    least = _SHARED_STEPS if shared else 1
    steps = manoeuvres[0].substeps or least
    tasks = [wheels_task(manoeuvre, steps, size) for manoeuvre in manoeuvres]
    drawn = draw_all(tasks, count, seed)
    if intervals < _LONG:
        return solve_in_fine_steps(tasks, drawn, report, room=room, least=least)[1]
    held = longer_intervals(intervals, _FIRST)
    first = [wheels_task(manoeuvre, steps, _FIRST, held) for manoeuvre in manoeuvres]
    parts = [_on_longer(part, held) for part in drawn]
    # What they are off by is mended where they are refined.
    found = solve_wheels(in_steps(first, parts, least), parts, report, room=room)
    return _refined(tasks, found, report, room, least)


def _on_longer(starts: Starts, held: Counts) -> Starts:
    """Starts on longer intervals, filled up."""
    nodes = np.concatenate([[0], np.cumsum(held)])
    u, x = averaged(starts.u[:, : nodes[-1]], held), starts.x[:, nodes]
    more = _FIRST - len(held)
    return starts._replace(u=filled(u, more), x=filled(x, more, still=True))


def _refined(
    tasks: Sequence[WheelsTask],
    found: Sequence[Solved],
    report: Report | None,
    room: int,
    least: int,
) -> tuple[Solved, ...]:
    """Answers, the best of which are solved again on the manoeuvres' own intervals."""
    best = [_worth_refining(solved) for solved in found]
    parts = []
    for task, solved, rows in zip(tasks, found, best, strict=True):
        chosen = solved.pick(rows)
        parts.append(rolled_out(task, chosen.torque, chosen.dipole))
    settings = replace(settings_for(tasks[0].form), barrier=_BARRIER, max_iterations=_PASSES)
    told = None if report is None else _refining(report)
    refined = solve_in_fine_steps(tasks, parts, told, None, room, settings, least)[1]
    return tuple(
        solved.replaced(rows, better)
        for solved, rows, better in zip(found, best, refined, strict=True)
    )


def _worth_refining(solved: Solved) -> Counts:
    """Best answers that the solver is content with, those that differ first."""
    content = np.isin(solved.status, (Status.CONVERGED, Status.FEASIBLE))
    order = np.lexsort((-np.nan_to_num(solved.claimed, nan=-np.inf), ~content))
    claimed = solved.claimed[order]
    apart = np.abs(np.diff(claimed, prepend=np.inf)) > _APART * np.abs(claimed)
    return np.concatenate([order[apart], order[~apart]])[:_REFINED]


def _refining(report: Report) -> Report:
    return lambda stage, done: report(f"{stage}, the best few in its own intervals", done)
