"""Multi-start search for controls with bounds of their own, such as one-sided thrusters.

1. Reweighted Newton steps between the bounds decide which intervals are active, from every start.
2. The support is frozen and the L1 effort is minimised on it.
3. If no start arrives, bang-off-bang supports are tried, the shortest first.
4. The best supports found are improved by dropping and moving single intervals.
5. Bang-off-bang supports of fewer and fewer intervals are tried for as long as some arrive.
6. Where the printed cost is minimised, that answer competes with doing nothing, with starts on the
   cost itself and with bang-off-bang torques that leave the target aside.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from jaxatt.problems.hands_off.search.bang_off_bang import cheapest_bang_off_bang, try_bang_off_bang
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate, join, support_of
from jaxatt.problems.hands_off.search.local_search import improve
from jaxatt.problems.hands_off.search.polish import Method, decide, polish
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats

_IMPROVED = 2
_LONGEST_BURST = 24
_TRACE = 1e-2
"""Scaled controls below it are traces of an approximate L1 optimum."""

MakeMethod = Callable[[str, str], Method]
"""(what decides the support, what to tell of progress) -> how to solve."""


@dataclass(frozen=True)
class BoundedFound:
    """Outcome of a search.

    starts : one candidate a start.  pool : all answers, the starts included.
    """

    starts: Candidates
    pool: Candidates


def search_bounded(
    task: SparseTask, count: int, seed: int, guess: Floats | None, method: MakeMethod
) -> BoundedFound:
    """Search a task whose system has bounds; see `search.search`."""
    if task.goal.terminal == "penalty":
        return _cheapest(task, count, seed, guess, method)
    starts = from_bounded_starts(task, count, seed, guess, method)
    pool = starts
    if not starts.verdict.reached.any() and task.goal.kind != "l1":
        pool = join(starts, *_rescued(task, method))
    if task.goal.kind == "l1":
        return BoundedFound(starts, pool)
    return BoundedFound(starts, _shortened(task, _improved(task, pool, method, True), method))


def from_bounded_starts(
    task: SparseTask, count: int, seed: int, guess: Floats | None, method: MakeMethod
) -> Candidates:
    """Answers of `count` starts, without any improvement afterwards."""
    scaled = None if guess is None else task.from_controls(guess)
    drawn = draw(seed, count, task.intervals, task.size, task.long_way_probability(), scaled)
    drawn = drawn._replace(u=np.abs(drawn.u))
    decides = "l1" if task.goal.kind == "l1" else "l0"
    u, supports = decide(task, drawn, method(decides, "deciding which intervals are active"))
    ended = polish(task, u, supports, drawn.sign, method(decides, "polishing"))
    if decides == "l0":
        return ended
    # The least effort leaves traces that only an exact linear programme would make zero.
    u = task.from_controls(ended.controls)
    kept = np.abs(u).max(axis=-1, keepdims=True) > _TRACE
    pruned = polish(task, u, kept, drawn.sign, method(decides, "polishing"))
    return pruned.where(pruned.verdict.reached | ~ended.verdict.reached, ended)


def _rescued(task: SparseTask, method: MakeMethod) -> list[Candidates]:
    """Try bang-off-bang supports, longer and longer, until some reach."""
    size = 2
    while size <= task.intervals:
        tried = try_bang_off_bang(task, size, method("l0", "trying bang-off-bang"))
        if tried.verdict.reached.any():
            return [tried.pick(np.flatnonzero(tried.verdict.reached))]
        size = max(size + 1, round(1.3 * size))
    return []


def _shortened(task: SparseTask, pool: Candidates, method: MakeMethod) -> Candidates:
    """Pool with the shortest bang-off-bang answer added, if it beats what is there."""
    best = pool.pick(pool.order(True)[0])
    if not best.verdict.reached[0]:
        return pool
    size = int(best.rank[0, 1]) - 1
    found: Candidates | None = None
    while size > 0:
        tried = try_bang_off_bang(task, size, method("l0", "trying fewer intervals"))
        if not tried.verdict.reached.any():
            break
        found, size = tried.pick(np.flatnonzero(tried.verdict.reached)), size - 1
    if found is None:
        return pool
    supports = np.stack([support_of(task, controls) for controls in found.controls])
    u = task.from_controls(found.controls)
    return join(pool, found, polish(task, u, supports, found.sign, method("l0", "polishing")))


def _improved(
    task: SparseTask, pool: Candidates, method: MakeMethod, reached_first: bool
) -> Candidates:
    moving = method("l0", "moving single intervals")
    order = pool.order(reached_first)[:_IMPROVED]
    usable = [i for i in order if pool.verdict.reached[i] or not reached_first]
    tried: set[bytes] = set()
    return join(pool, *(improve(task, pool.pick(index), moving, tried) for index in usable))


def _cheapest(
    task: SparseTask, count: int, seed: int, guess: Floats | None, method: MakeMethod
) -> BoundedFound:
    starts = from_bounded_starts(task, count, seed, guess, method)
    most = min(_LONGEST_BURST, task.intervals // 2)
    bursts = cheapest_bang_off_bang(task, most, method("l0", "trying bang-off-bang"))
    pool = _improved(task, join(starts, bursts), method, False)
    arriving = task.reaching()
    arrived = search_bounded(arriving, count, seed, guess, method).pool
    first = arrived.pick(arrived.order(True)[:1])
    again = evaluate(
        task, task.from_controls(first.controls), first.status, first.iterations, first.sign
    )
    return BoundedFound(starts, join(pool, again))
