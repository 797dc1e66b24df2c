"""Search under path constraints, which are enforced only where an answer violates them.

They are left out at first, and only judged; where the flights say that they matter the search is
made again with them in the way.  Between the nodes a search knows them roughly only, the
flights exactly: what they find in excess is added to a margin of the limits, and the supports
that were found are polished again.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from jaxatt.problems.hands_off.search.candidates import Candidates, better, join, support_of
from jaxatt.problems.hands_off.search.polish import Method, polish
from jaxatt.problems.hands_off.search.search import Found, chosen, search
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.motor_torques import motor_excess
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import speed_excess
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report, chunk_for

_ROUNDS = 3
_LITTLE = 0.02
"""Excess up to which a margin is worth a try: [rad] over a cone, or a share of a rate limit."""
_BEYOND = 1.2
"""Factor of the excess by which a margin grows."""
_LESS = 1.05
"""Factor of the torque that motors lack by which the search has less of it."""
_LEAST = 0.95
"""Share of a torque limit that a search can do without."""


@dataclass(frozen=True)
class Limited:
    """Outcome of a search under path constraints.

    task : as it was searched in the end.  found : what was found.
    """

    task: SparseTask
    found: Found


def search_within_limits(
    task: SparseTask,
    count: int,
    seed: int,
    guess: Floats | None = None,
    inner: str = "auto",
    report: Report | None = None,
) -> Limited:
    """As `search`, for a task whose path constraints are at first only judged.

    Motors whose torque falls with speed, or that work against friction, are judged too; where they
    lack torque, the search is made again with less of it.
    """
    outcomes = [_within_path_limits(task, count, seed, guess, inner, report)]
    for _ in range(_ROUNDS):
        weaker = _weaker(outcomes[-1], task)
        if weaker is None:
            break
        outcomes.append(_within_path_limits(weaker, count, seed, guess, inner, report))
    return _best(outcomes)


def _within_path_limits(
    task: SparseTask,
    count: int,
    seed: int,
    guess: Floats | None,
    inner: str,
    report: Report | None,
) -> Limited:
    if not isinstance(task, SlewTask) or not task.has_path_limits:
        return Limited(task, search(task, count, seed, guess, inner, report))
    anywhere = search(task.ignoring_path_limits(), count, seed, guess, inner, report)
    last = Limited(task, _judged(task, anywhere))
    if _violating(last) is None:
        return last
    outcomes = [last]
    for speeds in _speed_limits_tried(task):
        constraint_margin = np.zeros(len(task.pointing.cones) + 1) if task.pointing else None
        enforced = task.enforcing(constraint_margin, speeds)
        found = search(enforced, count, seed, guess, inner, report)
        outcomes.append(Limited(enforced, found))
        for _ in range(_ROUNDS):
            tightened = _tightened(outcomes[-1])
            if tightened is None:
                break
            found = _polished_again(tightened, found, inner)
            outcomes.append(Limited(tightened, found))
        if _violating(outcomes[-1]) is None:
            break
    return _best(outcomes)


def _best(outcomes: list[Limited]) -> Limited:
    """The best that reaches: a larger margin may cost an answer that the round before it found."""
    reached = [outcome for outcome in outcomes if outcome.found.best.verdict.reached[0]]
    best = (reached or outcomes[-1:])[0]
    for other in reached[1:]:
        if better(other.found.best.rank[0], best.found.best.rank[0]):
            best = other
    return best


def _judged(task: SlewTask, found: Found) -> Found:
    """Judge an answer that was found without path constraints by them."""

    def judged(candidates: Candidates) -> Candidates:
        return replace(candidates, verdict=task.verify(candidates.controls)[0])

    starts, best = judged(found.starts), judged(found.best)
    return chosen(task, starts, join(starts, best))


def _speed_limits_tried(task: SlewTask) -> Iterator[bool]:
    """Whether wheel speed limits are enforced: first without, then with."""
    if task.pointing:
        yield False
    if task.has_speed_limits and not task.form.has_thrusters:
        yield True


def _violating(outcome: Limited) -> Candidates | None:
    """Best answer that only a path constraint rules out, or None."""
    found, soft = outcome.found, outcome.task.goal.terminal == "penalty"
    pool = join(found.best, found.starts)
    if not soft:
        pool = pool.pick(np.flatnonzero(pool.verdict.arrives))
        if not len(pool.controls):
            return None
    first = pool.pick(pool.order(False)[0])
    if first.verdict.margin_violation[0] <= Verdict.MARGIN_TOLERANCE:
        return None
    beaten = soft or not found.best.verdict.reached[0]
    return first if beaten or better(first.rank[0], found.best.rank[0]) else None


def _polished_again(task: SlewTask, found: Found, inner: str) -> Found:
    """Minimise the effort on the same supports within the limits of a task."""
    every = join(found.best, found.starts)
    method = Method(
        "l1" if task.goal.kind == "l1" else "l0",
        "gauss-newton" if inner == "auto" else inner,
        inner == "auto",
        chunk_for(len(found.starts.controls)),
    )
    supports = np.stack([support_of(task, controls) for controls in every.controls])
    u = task.from_controls(every.controls)
    polished = polish(task, u, supports, every.sign, method)
    kept = polished.where(polished.verdict.reached | ~every.verdict.reached, every)
    starts = kept.pick(np.arange(1, len(every.controls)))
    return chosen(task, starts, kept)


def _tightened(outcome: Limited) -> SlewTask | None:
    """The task with larger margins for the violating answer; None without need or use."""
    first, task = _violating(outcome), outcome.task
    if first is None or not isinstance(task, SlewTask):
        return None
    flown = task.fly(first.controls)
    margin, excess = task.constraint_margin, np.zeros(1)
    over = np.zeros(task.craft.wheels.count)
    if margin is not None:
        excess = task.watch(flown).excess[0]
        margin = margin + np.where(excess > 0.0, _BEYOND * excess, 0.0)
    if task.limits_speeds:
        over = np.maximum(speed_excess(task.craft.wheels, task.wheel_speeds(flown)[0])[0], 0.0)
    worst = max(excess.max(), over.max(initial=0.0))
    if not 0.0 < worst <= _LITTLE:
        return None
    return task.enforcing(margin, task.limits_speeds, task.speed_margin + _BEYOND * over)


def _weaker(outcome: Limited, asked: SparseTask) -> SlewTask | None:
    """The task that was asked for with less torque, where the motors of an answer lack some."""
    first, task = _violating(outcome), outcome.task
    if first is None or not isinstance(task, SlewTask) or not isinstance(asked, SlewTask):
        return None
    speeds = task.wheel_speeds(task.fly(first.controls))[0]
    lacks = motor_excess(task.craft.wheels, task.wheel_torque(first.controls), speeds)[0]
    if not lacks.max(initial=0.0) > Verdict.MARGIN_TOLERANCE:
        return None
    return asked.weaker(np.minimum(task.torque_margin + _LESS * np.maximum(lacks, 0.0), _LEAST))
