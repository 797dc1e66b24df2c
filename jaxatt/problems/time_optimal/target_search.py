"""Search of a turn for many targets in one batch, from starts or from answers close by."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import numpy as np

from jaxatt.multistart.staged_chunks import rows_of_stages
from jaxatt.optimize.interior_point.solver import InteriorSettings
from jaxatt.problems.time_optimal.batch import solve_paths
from jaxatt.problems.time_optimal.paths import Paths
from jaxatt.problems.time_optimal.search import FreeTimeFound, evaluate
from jaxatt.problems.time_optimal.targets import drawn_starts
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report

_WARM = InteriorSettings(barrier=1e-2)


def search_targets(
    task: ReorientationTask,
    targets: Floats,
    starts: int,
    seed: int,
    near: Sequence[FreeTimeFound] | None,
    report: Report | None,
) -> list[FreeTimeFound]:
    """Find the best turn to each of many targets (M, 4).

    starts : of every target, unless there are answers `near`, (M,), to go on from; where one leads
    nowhere, its target is searched from its starts.
    """
    rows = rows_of_stages(starts * len(targets), task.intervals)  # one program for both
    if near is None:
        paths = drawn_starts(task, targets, starts, seed)
        return _solved(task, targets, paths, None, rows, report)
    found = _solved(task, targets, _from_answers(task, targets, near), _WARM, rows, report)
    lost = [k for k, one in enumerate(found) if not one.answered]
    if lost:
        again = drawn_starts(task, targets[lost], starts, seed)
        fresh = _solved(task, targets[lost], again, None, rows, report)
        for k, one in zip(lost, fresh, strict=True):
            found[k] = one
    return found


def _solved(
    task: ReorientationTask,
    targets: Floats,
    paths: Paths,
    settings: InteriorSettings | None,
    rows: int,
    report: Report | None,
) -> list[FreeTimeFound]:
    """Solve all paths at once, and judge those of each target."""
    solution = solve_paths(task, paths, settings, None, report, rows)
    each = len(paths.step) // len(targets)
    found = []
    for k, q in enumerate(targets):
        own = slice(k * each, (k + 1) * each)
        some = Paths(*(leaf[own] for leaf in paths))
        part = jax.tree.map(lambda leaf, own=own: leaf[own], solution)
        found.append(evaluate(task.aiming_at(q), some, part))
    return found


def _from_answers(task: ReorientationTask, targets: Floats, near: Sequence[FreeTimeFound]) -> Paths:
    """One start a target: the best answer of a search, the same way round."""
    signs = [-1.0 if one.long_way[one.best] else 1.0 for one in near]
    return Paths(
        np.stack([one.scaled[one.best] for one in near]),
        np.stack([one.states[one.best] for one in near]),
        np.array([one.step[one.best] for one in near]),
        np.stack([task.aiming_at(q).reference(s) for q, s in zip(targets, signs, strict=True)]),
        np.full(len(near), task.goal.effort_weight),
    )
