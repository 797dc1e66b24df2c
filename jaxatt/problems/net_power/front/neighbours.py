"""Search for manoeuvres that differ in one number, whose answers start each other.

All starts of all manoeuvres are one batch.  Then every manoeuvre is solved again from the paths of
its two neighbours, flown in its own time and within its own limits, as long as any of them gains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.problems.net_power.answers import flown_again
from jaxatt.problems.net_power.found import Flown, Solved
from jaxatt.problems.net_power.manoeuvre import Manoeuvre
from jaxatt.problems.net_power.wheels.host import exponential, product
from jaxatt.problems.net_power.wheels.solve import solve_in_fine_steps, solve_wheels
from jaxatt.problems.net_power.wheels.starts import Starts, draw_starts, follow
from jaxatt.problems.net_power.wheels.task import WheelsTask, wheels_task
from jaxatt.problems.net_power.wheels.within_limits import keeping_to, within_limits
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

_ROUNDS = 4
_GAIN = 1e-6
"""Of the energy gained or spent, from which on another answer is better."""


@dataclass(frozen=True, eq=False)
class Point:
    """Best answer to one of the manoeuvres.

    best : with the flight of the answer.  of_starts : all answers of its own starts.
    """

    best: Flown
    of_starts: Flown

    @property
    def passed_on(self) -> bool:
        """Whether the answer was found from one of a neighbour."""
        return self.best is not self.of_starts


def search_neighbours(
    manoeuvres: Sequence[Manoeuvre], count: int, seed: int, report: Report | None
) -> list[Point]:
    """Solve manoeuvres of one form, ordered by what they differ in, from `count` starts each."""
    # The same for few starts as for many, so that both share a compiled program.
    rows = rows_of_stages(count * len(manoeuvres), manoeuvres[0].intervals)

    def searched(some: Sequence[Manoeuvre]) -> Sequence[Solved]:
        coarse = [wheels_task(manoeuvre) for manoeuvre in some]
        drawn = [draw_starts(task, count, seed) for task in coarse]
        return solve_in_fine_steps(coarse, drawn, report, rows, len(manoeuvres))[1]

    solved = within_limits(manoeuvres, searched)
    limits = [answers.limits for answers in solved]
    if any(limits):
        manoeuvres = [keeping_to(m, own) for m, own in zip(manoeuvres, limits, strict=True)]
    substeps = max(answers.substeps for answers in solved)
    tasks = [wheels_task(manoeuvre, substeps) for manoeuvre in manoeuvres]
    points = []
    for manoeuvre, answers in zip(manoeuvres, solved, strict=True):
        flown = flown_again(manoeuvre, answers)
        points.append(Point(flown, flown))
        if report is not None:
            report("flying", count)
    told = None if report is None else _again(report)
    fresh = list(range(len(points)))
    for _ in range(_ROUNDS):
        fresh = _passed_on(tasks, points, fresh, told, rows)
        if not fresh:
            break
    return points


def _passed_on(
    tasks: Sequence[WheelsTask],
    points: list[Point],
    fresh: Sequence[int],
    report: Report | None,
    rows: int,
) -> list[int]:
    """Solve the neighbours of points whose answer is new; return those that gained."""
    last = len(points) - 1
    sources = {
        k: [n for n in (k - 1, k + 1) if n in fresh and points[n].best.reached[points[n].best.best]]
        for k in range(last + 1)
    }
    asked = [k for k, near in sources.items() if near]
    if not asked:
        return []
    chosen = [tasks[k] for k in asked]
    parts = [_starts(tasks[k], [points[n].best for n in sources[k]]) for k in asked]
    gained = []
    for k, solved in zip(asked, solve_wheels(chosen, parts, report, rows), strict=True):
        found = flown_again(tasks[k].manoeuvre, solved)
        if _better(found, points[k].best):
            points[k] = replace(points[k], best=found)
            gained.append(k)
    return gained


def _starts(task: WheelsTask, answers: Sequence[Flown]) -> Starts:
    """Starts of a task along the flown paths of other answers, with as many nodes."""
    paths = np.stack([answer.flight.q_ib[answer.best] for answer in answers])
    return follow(task, _beyond(task, paths))


def _beyond(task: WheelsTask, paths: Floats) -> Floats:
    """Attitudes (S, N + 2, 4): the paths (S, N + 1, 4), and where they go on to."""
    end = task.manoeuvre.end
    rate = np.zeros(3) if end is None else np.asarray(end.facing(paths[:, -1:]).omega_ib, float)
    turned = exponential(task.manoeuvre.step * rate)
    return np.concatenate([paths, product(paths[:, -1:], turned)], axis=1)


def _better(new: Flown, old: Flown) -> bool:
    """Whether the best of some answers is better than that of others."""
    reached = bool(new.reached[new.best]), bool(old.reached[old.best])
    if reached[0] != reached[1]:
        return reached[0]
    least = _GAIN * old.flight.energy.turnover
    return bool(new.score[new.best] > old.score[old.best] + least)


def _again(report: Report) -> Report:
    return lambda stage, done: report(f"{stage} again, from neighbours", done)
