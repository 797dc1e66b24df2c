"""Fewer active intervals of every answer: the smallest are left out, neighbours are let in.

Where a limit binds, a support that was decided at random ends with many intervals that a full one
could do without: what they contribute fits into others, and those that lie further out have the
longer lever.  So the smallest are left out, as many as the target allows; then the intervals beside
the active ones are let in, between which the least effort moves to where it does most, and the
smallest are left out again.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.reweighting.support import Mask
from jaxatt.problems.hands_off.search.candidates import Candidates, better, join, support_of
from jaxatt.problems.hands_off.search.polish import Method, polish
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Flags

_ROUNDS = 2


def with_fewer_intervals(task: SparseTask, found: Candidates, method: Method) -> Candidates:
    """The same answers (S,), with fewer active intervals where such are found that reach."""
    best = _without_the_smallest(task, found, method)
    for _ in range(_ROUNDS):
        grown = _grown(task, best)
        wider = polish(task, task.from_controls(best.controls), grown, best.sign, method)
        tried = _without_the_smallest(task, wider, method)
        best = best.where(~_improved(tried, best), tried)
    return best


def _without_the_smallest(task: SparseTask, found: Candidates, method: Method) -> Candidates:
    """Leave out as many of the smallest active intervals as the target allows, by bisection."""
    most = np.where(found.verdict.reached, _supports(task, found).sum(axis=(1, 2)), 0)
    least = np.zeros_like(most)
    while len(left := np.flatnonzero(most - least > 1)):
        now, size = found.pick(left), (most[left] + least[left]) // 2
        kept = _largest(task, now, size)
        tried = polish(task, task.from_controls(now.controls) * kept, kept, now.sign, method)
        arrived = tried.verdict.reached
        most[left[arrived]] = _supports(task, tried).sum(axis=(1, 2))[arrived]
        least[left[~arrived]] = size[~arrived]
        found = _replaced(found, left[arrived], tried.pick(np.flatnonzero(arrived)))
    return found


def _replaced(found: Candidates, places: npt.NDArray[np.int64], others: Candidates) -> Candidates:
    """Candidates with others in the places given."""
    order = np.arange(len(found.controls))
    order[places] = len(order) + np.arange(len(places))
    return join(found, others).pick(order)


def _supports(task: SparseTask, found: Candidates) -> Mask:
    return np.stack([support_of(task, controls) for controls in found.controls])


def _largest(task: SparseTask, found: Candidates, size: npt.NDArray[np.int64]) -> Mask:
    """Supports (S, N, g) of the `size` (S,) groups that are largest for what they cost."""
    magnitude = np.abs(task.from_controls(found.controls))
    if task.shared:
        magnitude = magnitude.max(axis=-1, keepdims=True)
    weight = np.maximum(np.asarray(task.arguments.weight), np.finfo(float).tiny)
    worth = magnitude / weight[:, None]
    place = np.argsort(np.argsort(-worth.reshape(len(worth), -1), axis=1, kind="stable"), axis=1)
    kept: Mask = place.reshape(worth.shape) < size[:, None, None]
    return kept


def _grown(task: SparseTask, found: Candidates) -> Mask:
    """Supports with the allowed intervals beside every active one."""
    support = _supports(task, found)
    grown = support.copy()
    grown[:, 1:] |= support[:, :-1]
    grown[:, :-1] |= support[:, 1:]
    allowed = np.asarray(task.arguments.free)[:, : support.shape[-1]] > 0
    return np.asarray(grown & allowed)


def _improved(tried: Candidates, before: Candidates) -> Flags:
    """Whether answers tried (S,) reach, and were missed or cost more before."""
    ranks = zip(tried.rank, before.rank, strict=True)
    cheaper = np.array([better(new, old) for new, old in ranks])
    return np.asarray(tried.verdict.reached & (cheaper | ~before.verdict.reached))
