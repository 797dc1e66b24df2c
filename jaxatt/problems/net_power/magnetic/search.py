"""Search for the best manoeuvre by magnetorquers alone, for one or many weights of time at once.

1. All starts take passes with the curvature of the cost alone, which is positive whatever the path:
   far from an answer the exact one is so indefinite that every step would be short.
2. They go on with exact second derivatives to a minimum.
3. Every answer is flown with finer steps.  Any of them may be the best for any weight of time, so
   the best few of all for each weight, and those of its neighbours, are solved again with that
   weight and a sharper shadow, until nothing improves.  The answer for a weight is the best of all
   flights; so the final time cannot grow with the weight.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.interior_point.solver import InteriorSettings
from jaxatt.optimize.interior_point.state import SMALL_SHIFTS
from jaxatt.problems.net_power.magnetic.answers import Answers, answers_of, distinct, usable
from jaxatt.problems.net_power.magnetic.batch import kept_finite, solve
from jaxatt.problems.net_power.magnetic.manoeuvre import FreeManoeuvre
from jaxatt.problems.net_power.magnetic.starts import Starts, make_starts
from jaxatt.problems.net_power.magnetic.task import MagneticTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Progress, Report

_ROUGH = InteriorSettings(
    tolerance=1e-6, barrier=1e-2, max_iterations=80, shifts=SMALL_SHIFTS, crossover_from=0.0
)
_EXACT = replace(_ROUGH, barrier=1e-3, max_iterations=150)
AGAIN = replace(_ROUGH, barrier=1e-5, max_iterations=100)
WIDTHS = (0.004, 0.001)
"""[rad] Of the shadow's edges when answers are solved again."""
_ROUNDS = 4
_KEPT = 4
"""Answers that are solved again for each weight."""
_GAIN = 1e-5
"""Relative gain of the cost that is worth another round."""
DISAGREEMENT = 2e-3
"""Relative difference of claimed and flown energy beyond which steps are halved."""


@dataclass(frozen=True, eq=False)
class FrontFound:
    """Best answers for weights of time (K,).

    answers : (A,) all of them, those of the starts first.  starts : number of those.
    best : (K,), index of the answer for each weight.  cost : (K,), of its flight.
    substeps : Runge-Kutta steps an interval of the last solves.
    """

    task: MagneticTask
    time_weight: Floats
    answers: Answers
    starts: int
    best: npt.NDArray[np.int64]
    cost: Floats
    substeps: int

    @property
    def chosen(self) -> Answers:
        """The best answers, leading axis K."""
        return self.answers.pick(self.best)

    def of_starts(self, k: int) -> Answers:
        """For weight k the best answer that goes back to each of the starts, (S,)."""
        merit = self.answers.merit(self.task, float(self.time_weight[k]))
        order = np.argsort(-merit, kind="stable")
        rows = np.zeros(self.starts, int)
        rows[self.answers.origin[order]] = order
        return self.answers.pick(rows)

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """Whether they reach the target within its tolerances, (K,)."""
        return self.chosen.shortfall(self.task) <= 1.0


def search_front(
    manoeuvre: FreeManoeuvre,
    time_weight: Floats,
    count: int,
    seed: int,
    report: Report | None = None,
) -> FrontFound:
    """Find the best answers for all weights of time (K,) in one batch.

    count : starts for each weight.
    """
    task, weights = MagneticTask(manoeuvre), np.asarray(time_weight, float)
    starts = make_starts(task, count * len(weights), seed)
    starts = replace(starts, time_weight=weights[np.arange(count * len(weights)) % len(weights)])
    found = solved(task, starts, report)
    first, substeps = len(found.final_time), task.form(True).substeps
    best = _least(task, found, weights)
    for turn in range(_ROUNDS):
        width = WIDTHS[min(turn, len(WIDTHS) - 1)]
        chosen, weight = _chosen(task, found, weights)
        again = chosen.starts(weight)
        parameters = task.sharper(width)
        if (found.pick(_argmin(task, found, weights)).disagreement > DISAGREEMENT).any():
            substeps *= 2
        form = task.form(True, substeps)
        progress = _progress(report, "solving the best again")
        solution = solve(form, again, parameters, AGAIN, progress)
        found = Answers.join([found, answers_of(form, again, solution, parameters, chosen)])
        better = _least(task, found, weights)
        if turn and (best - better <= _GAIN * np.abs(best)).all():
            best = better
            break
        best = better
    index = _argmin(task, found, weights)
    return FrontFound(task, weights, found, first, index, best, substeps)


def search_magnetic(
    manoeuvre: FreeManoeuvre, count: int, seed: int, report: Report | None = None
) -> FrontFound:
    """Find the best answer for the manoeuvre's own weight of time from `count` starts."""
    return search_front(manoeuvre, np.array([manoeuvre.time_weight]), count, seed, report)


def solved(task: MagneticTask, starts: Starts, report: Report | None = None) -> Answers:
    """Solve from all starts, first with a positive curvature, then with the exact one."""
    rough, exact, p = task.form(False), task.form(True), task.parameters
    near = solve(rough, starts, p, _ROUGH, _progress(report, "approaching from all starts"))
    _, u, x = kept_finite(starts, near)
    nearer = replace(starts, u=u, x=x)
    found = solve(exact, nearer, p, _EXACT, _progress(report, "solving from all starts"))
    answers = answers_of(exact, nearer, found, p)
    return replace(answers, iterations=answers.iterations + np.asarray(near.iterations))


def _chosen(task: MagneticTask, found: Answers, weights: Floats) -> tuple[Answers, Floats]:
    """The best few answers for every weight, the same number for each, and those weights."""
    rows = []
    for weight in weights:
        merit = np.where(usable(found), found.merit(task, weight), np.inf)
        best = distinct(merit, found.final_time, _KEPT)
        rows.append(np.pad(best, (0, _KEPT - len(best)), mode="edge"))
    return found.pick(np.concatenate(rows)), np.repeat(weights, _KEPT)


def _argmin(task: MagneticTask, found: Answers, weights: Floats) -> npt.NDArray[np.int64]:
    return np.array([int(np.argmin(found.merit(task, weight))) for weight in weights])


def _least(task: MagneticTask, found: Answers, weights: Floats) -> Floats:
    return np.array([float(found.merit(task, weight).min()) for weight in weights])


def _progress(report: Report | None, stage: str) -> Progress | None:
    return None if report is None else lambda done: report(stage, done)
