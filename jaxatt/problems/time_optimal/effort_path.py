"""Optima for many weights rho of effort at once, from a warm start.

The best answer at one weight, found from many starts, begins the solves at all other weights, which
are lanes of one batch.  Then every weight starts again from its neighbours' answers; what gets
cheaper is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import numpy as np
import numpy.typing as npt

from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.interior_point.solver import InteriorSettings, InteriorSolution
from jaxatt.optimize.status import Status
from jaxatt.problems.time_optimal.batch import solve_paths
from jaxatt.problems.time_optimal.paths import Paths
from jaxatt.problems.time_optimal.search import FreeTimeFound, evaluate, search_free_time
from jaxatt.problems.time_optimal.starts import starts_of
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

_WARM = InteriorSettings(barrier=1e-2)


@dataclass(frozen=True, eq=False)
class EffortPath:
    """Optima of one task for R weights, in ascending order.

    weights : (R,) [1/(N m)^2].  final_time, cost : (R,) [s].  quadratic_effort : (R,) [(N m)^2 s].
    torques : (R, N, n + m) [N m].  step : (R,) [s].
    converged, reached : (R,), by the solver's test and by flights with fine steps.
    found : each optimum as a search of one start returns it.
    """

    weights: Floats
    final_time: Floats
    quadratic_effort: Floats
    cost: Floats
    torques: Floats
    step: Floats
    converged: npt.NDArray[np.bool_]
    reached: npt.NDArray[np.bool_]
    found: tuple[FreeTimeFound, ...]


def effort_path(
    task: ReorientationTask,
    weights: Floats,
    count: int,
    seed: int,
    report: Report | None = None,
) -> EffortPath:
    """Solve a task for weights (R,) [1/(N m)^2]; the task's own weight is not used.

    count, seed : starts of the search at the middle weight.
    """
    weights = np.sort(np.asarray(weights, float))
    middle = task.weighing(float(weights[len(weights) // 2]))
    best = search_free_time(middle, count, seed, report)
    rows = rows_of_stages(count, task.intervals)  # as in the search: nothing is compiled again
    paths = starts_of(middle, 1, seed)
    begin = _warm(middle, best, paths, weights)
    solution = solve_paths(middle, begin, _WARM, None, report, rows)
    for shift in (1, -1):
        again = solve_paths(middle, _neighbours(begin, solution, shift), _WARM, None, report, rows)
        solution = _cheaper(solution, again)
    found = [
        evaluate(task.weighing(float(w)), _lane(begin, i), _solved(solution, i))
        for i, w in enumerate(weights)
    ]
    torques = np.concatenate([f.controls for f in found])
    step = np.concatenate([f.step for f in found])
    return EffortPath(
        weights,
        task.intervals * step,
        task.quadratic_effort(torques, step),
        np.concatenate([f.cost for f in found]),
        torques,
        step,
        np.concatenate([f.status == Status.CONVERGED for f in found]),
        np.concatenate([f.reached for f in found]),
        tuple(found),
    )


def _warm(task: ReorientationTask, best: FreeTimeFound, paths: Paths, weights: Floats) -> Paths:
    """Start every weight from the best answer's controls and states."""
    one = best.best
    count = len(weights)

    def same(value: Floats) -> Floats:
        return np.repeat(value[None], count, axis=0)

    sign = -1.0 if best.long_way[one] else 1.0
    return Paths(
        same(best.scaled[one]),
        same(best.states[one]),
        same(best.step[one]),
        same(task.reference(sign)),
        weights,
    )


def _neighbours(begin: Paths, solution: InteriorSolution, shift: int) -> Paths:
    """Start every weight from the answer of the next lower (1) or higher (-1) one."""
    index = np.clip(np.arange(len(begin.u)) - shift, 0, len(begin.u) - 1)
    states = np.asarray(solution.x)[index]
    good = np.isfinite(states).all(axis=(1, 2))[:, None, None]
    return begin._replace(
        u=np.where(good, np.asarray(solution.u)[index], begin.u),
        states=np.where(good, states, begin.states),
        step=np.where(good[:, 0, 0], np.exp(states[:, -1, -1]), begin.step),
    )


def _cheaper(one: InteriorSolution, other: InteriorSolution) -> InteriorSolution:
    """Lane by lane, the converged and cheaper of two solutions."""
    better = (other.status == Status.CONVERGED) & (
        (one.status != Status.CONVERGED) | (other.objective < one.objective * (1.0 - 1e-9))
    )

    def chosen(a: Floats, b: Floats) -> Floats:
        return np.where(better.reshape(-1, *[1] * (np.ndim(a) - 1)), b, a)

    return jax.tree.map(chosen, one, other)


def _lane(paths: Paths, i: int) -> Paths:
    return Paths(*(value[i : i + 1] for value in paths))


def _solved(solution: InteriorSolution, i: int) -> InteriorSolution:
    return jax.tree.map(lambda leaf: leaf[i : i + 1], solution)
