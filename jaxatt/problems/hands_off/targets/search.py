"""Fewest active intervals for many targets at once; every round is one batch over all of them.

1. Two intervals, far apart first, decide nearly all targets that no torque limit stands in the way
   of: six rows have six unknowns, and torque early and late has the longest lever.
2. The others get bursts at both ends, longer and longer until one reaches; then one interval fewer,
   with one between.
3. For those that still take more than two, supports are decided from random starts, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.reweighting.support import Mask
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.bang_off_bang import bang_off_bang_supports, supports_between
from jaxatt.problems.hands_off.search.batch import broadcast_lanes
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate, join, support_of
from jaxatt.problems.hands_off.search.polish import (
    SETTLE,
    SETTLED,
    Method,
    decide,
    polish,
    reweight,
    screen,
)
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.runtime.arrays import Floats

Rows = npt.NDArray[np.int64]

_PAIR = 2
_AT_ONCE = 8192
"""Rows of one batch, which bounds its memory."""


class Trials(NamedTuple):
    """Supports (S, N, 1) to be tried for one target, and ways round (S,)."""

    supports: Mask
    sign: Floats


def search_targets(task: SlewTask, starts: int, seed: int) -> Candidates:
    """The best answer to every target of a task, see `SlewTask.aiming_at`; leading axis M.

    starts : random ones of each target that takes more than two intervals.
    """
    method = Method("l0")
    best = _pairs(task, method)
    left = np.flatnonzero(~best.verdict.reached)
    if len(left):
        bursts = _bursts(task.pick(left), method)
        best = best if bursts is None else _better_of(best, left, bursts)
    left = np.flatnonzero(~best.verdict.reached | (best.rank[:, 1] > _PAIR))
    if len(left) and starts:
        best = _better_of(best, left, _random(task.pick(left), starts, seed, method))
    return best


def _pairs(task: SlewTask, method: Method) -> Candidates:
    """Answers with two active intervals; they reach where any pair that is tried does.

    Close pairs are for targets so near that far ones take less torque than counts as active.
    """
    allowed = np.flatnonzero((np.asarray(task.arguments.free) > 0).any(axis=1))
    count = _count(task)
    u = np.zeros((count, task.intervals, task.size))
    way, least = np.ones(count), np.full(count, np.inf)
    place = len(allowed) - 1
    while place > 0:
        rows = np.flatnonzero(~np.isfinite(least))
        support = np.zeros((1, task.intervals, 1), bool)
        support[0, allowed[[0, place]]] = True
        for sign in task.ways if len(rows) else ():
            found, effort = _settled(task.pick(rows), support, sign, method)
            better = effort < least[rows]
            chosen = rows[better]
            u[chosen], way[chosen], least[chosen] = found[better], sign, effort[better]
        place //= 2
    status = np.where(np.isfinite(least), int(Status.FEASIBLE), int(Status.ITERATION_LIMIT))
    return evaluate(task, u, status, np.full(count, SETTLE.settling), way)


def _settled(task: SlewTask, support: Mask, sign: float, method: Method) -> tuple[Floats, Floats]:
    """Controls (S, N, b) on a support, and their effort (S,); infinite where they do not arrive.

    Two intervals that are not both active do not count as a pair.
    """
    free = np.broadcast_to(
        support * np.asarray(task.arguments.free)[None], (_count(task), task.intervals, task.size)
    )
    lanes = broadcast_lanes(np.zeros(free.shape), free, task.arguments.row_weight, np.asarray(sign))
    found = reweight(task, lanes, method, SETTLE)
    u = np.nan_to_num(np.asarray(found.u))
    controls = task.to_controls(u)
    pair = (np.abs(controls).max(axis=-1) > 0.0).sum(axis=1) >= _PAIR
    arrived = (np.asarray(found.residual) <= SETTLED) & pair
    return u, np.where(arrived, task.l1_effort(controls), np.inf)


def _bursts(task: SlewTask, method: Method) -> Candidates | None:
    """Answers with bursts at both ends, and those with one interval fewer and one between.

    None where no more than two intervals may be active.  Bursts are made longer step by step: one
    that is longer than it must be has much freedom, and is harder to find.
    """
    allowed = int((np.asarray(task.arguments.free) > 0).any(axis=1).sum())
    count, size = _count(task), _PAIR + 1
    left, found = np.arange(count), None
    while len(left) and size <= allowed:
        shapes = _both_ways(task, _shapes(task, size))
        tried = _tried(task, left, [shapes] * len(left), method)
        found = tried if found is None else _better_of(found, left, tried)
        left = left[~tried.verdict.reached]
        size += max(1, size // 8)
    if found is None:
        return None
    fewer = [supports_between(task, support_of(task, u)) for u in found.controls]
    rows = np.flatnonzero([len(f) > 0 for f in fewer] & found.verdict.reached)
    if not len(rows):
        return found
    trials = [Trials(fewer[row], np.full(len(fewer[row]), found.sign[row])) for row in rows]
    return _better_of(found, rows, _tried(task, rows, trials, method))


def _random(task: SlewTask, starts: int, seed: int, method: Method) -> Candidates:
    """The best of so many random starts of every target; the same starts for all of them."""
    drawn = draw(seed, starts, task.intervals, task.size, 0.5)
    best: list[Candidates] = []
    for some in _blocks(np.full(_count(task), starts)):
        rows, start = np.repeat(some, starts), np.tile(np.arange(starts), len(some))
        aimed = task.pick(rows)
        u, supports = decide(aimed, type(drawn)(*(part[start] for part in drawn)), method)
        ended = polish(aimed, u, supports, drawn.sign[start], method)
        best.append(ended.pick(_best_of(ended, rows, some)))
    return join(*best)


def _tried(task: SlewTask, rows: Rows, trials: list[Trials], method: Method) -> Candidates:
    """The best answer of each row on any of its supports; as many as rows."""
    best: list[Candidates] = []
    for some in _blocks(np.array([len(own.sign) for own in trials])):
        here = [trials[k] for k in some]
        index = np.repeat(rows[some], [len(own.sign) for own in here])
        masks, sign = (np.concatenate(part) for part in zip(*here, strict=True))
        rest = np.zeros((len(index), task.intervals, task.size))
        tried = screen(task.pick(index), rest, masks, sign, method)
        best.append(tried.pick(_best_of(tried, index, rows[some])))
    return join(*best)


def _blocks(sizes: Rows) -> list[Rows]:
    """Indices of neighbours that make a batch of about `_AT_ONCE` rows."""
    block = np.cumsum(sizes) // _AT_ONCE
    return [np.flatnonzero(block == k) for k in np.unique(block)]


def _best_of(found: Candidates, rows: Rows, wanted: Rows) -> Rows:
    """Index of the best answer for each of the wanted rows."""
    order = found.order(True)
    place = np.full(int(rows.max()) + 1, -1)
    # The last one that is written stays: so the best comes last.
    place[rows[order[::-1]]] = order[::-1]
    return np.asarray(place[wanted])


def _better_of(best: Candidates, rows: Rows, others: Candidates) -> Candidates:
    """The best answers with those of some rows replaced where the others are better."""
    count = len(best.status)
    both = join(best, others)
    owner = np.concatenate([np.arange(count), rows])
    return both.pick(_best_of(both, owner, np.arange(count)))


def _shapes(task: SlewTask, size: int) -> Mask:
    """Bursts (S, N, 1) of `size` intervals in all, about as long at both ends."""
    half = size // 2
    firsts = {half - 1, half, half + 1, size - half} & set(range(size + 1))
    return bang_off_bang_supports(task, [(first, size - first) for first in firsts])


def _both_ways(task: SlewTask, supports: Mask) -> Trials:
    ways = len(task.ways)
    return Trials(np.concatenate([supports] * ways), np.repeat(task.ways, len(supports)))


def _count(task: SlewTask) -> int:
    assert task.aims is not None
    return len(task.aims)
