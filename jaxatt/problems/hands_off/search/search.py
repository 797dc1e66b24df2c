"""Multi-start search for the sparsest control.

1. From every start a homotopy of reweighted Newton steps decides which intervals are active.
2. The support is frozen and the L1 effort is minimised on it, with all constraints; where one
   control is all that an interval has, intervals that it can do without are left out.
3. Where many intervals stay active, reweighted least effort from there makes them fewer.
4. The best supports found are improved by dropping and moving single intervals; of the best of
   all, one interval is tried in the place of two.
5. Every answer is flown again; only those flights are ranked and reported.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.optimize.reweighting.support import Mask
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.ahead import compiled_ahead
from jaxatt.problems.hands_off.search.bang_off_bang import fewest_bang_off_bang, one_between
from jaxatt.problems.hands_off.search.bounded_search import from_bounded_starts, search_bounded
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate, join, support_of
from jaxatt.problems.hands_off.search.elimination import with_fewer_intervals
from jaxatt.problems.hands_off.search.enumeration import from_pairs
from jaxatt.problems.hands_off.search.local_search import improve, merge
from jaxatt.problems.hands_off.search.polish import Method, decide, polish
from jaxatt.problems.hands_off.search.reweighted_effort import reweighted
from jaxatt.problems.hands_off.search.starts import Starts, draw
from jaxatt.problems.hands_off.sparse_program import DecidedBy
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import Report, chunk_for

_IMPROVED = 2
_FEW = 4
"""Active intervals up to which reweighted least effort is not tried to have fewer."""
_COMPARED = 2
"""Active intervals up to which an answer is not compared with bursts at both ends, nor merged."""


@dataclass(frozen=True)
class Found:
    """Outcome of a search.

    starts : one candidate a start.  best : the answer (S = 1), maybe better than every start.
    reaching : the best that reaches the target, None if nothing does.
    distinct_minima : different answers among the starts that reached the target.
    do_nothing_cost : the printed cost of doing nothing, where the printed cost is minimised.
    """

    starts: Candidates
    best: Candidates
    reaching: Candidates | None
    distinct_minima: int
    do_nothing_cost: float | None = None


def search(
    task: SparseTask,
    count: int,
    seed: int,
    guess: Floats | None = None,
    inner: str = "auto",
    report: Report | None = None,
) -> Found:
    """Find the best control of a task from `count` starts.

    guess : (N, b), the system's controls to start from; random pulses without it.
    inner : "auto" decides supports by reweighted Newton steps where that applies; the name of an
        inner minimiser lets the augmented Lagrangian do all of it.  "riccati" reweights and
        polishes stage by stage; "auto" does so where path constraints rule out pulses.
    """
    if task.system.decided_by is DecidedBy.BOUNDS and inner != "auto":
        raise ValueError(f'inner = {inner!r}: thrusters have a method of their own; choose "auto"')
    if inner == "riccati" and task.system.stages is None:
        raise ValueError("inner = 'riccati': this problem has no stages; choose \"auto\"")

    def method(decides: str, stage: str) -> Method:
        progress = None if report is None else lambda done: report(stage, done)
        reweights = inner == "auto"
        name = "gauss-newton" if reweights else inner
        return Method(decides, name, reweights, chunk_for(count), progress)

    def from_starts(decides: str) -> Candidates:
        deciding = method(decides, "deciding which intervals are active")
        return _ended(task, starts, deciding, method(decides, "polishing"))

    if task.system.decided_by is DecidedBy.BOUNDS:
        found = search_bounded(task, count, seed, guess, method)
        return chosen(task, found.starts, found.pool)
    scaled = None if guess is None else task.from_controls(guess)
    first = "l1" if task.goal.kind == "l1" else "l0"
    with compiled_ahead(task, method(first, ""), count):
        starts = _drawn(task, method(first, ""), count, seed, scaled)
        ended = from_starts(first)
    pool = ended
    reached_first = task.goal.terminal == "reach"
    counting = method("l0", "reweighting the effort")
    many = task.goal.kind == "l0" and reached_first and _most(task, ended) > _FEW
    if many and counting.spends_least_for(task):
        pool = join(ended, reweighted(task, ended, counting))
    if task.goal.kind != "l1" and not pool.verdict.reached.any():
        # Where counting leads nowhere, the L1 optimum is the source's own guess for the support.
        rescued = from_starts("l1")
        if rescued.verdict.reached.any():
            pool = ended = rescued
        elif pairs := _pairs(task, method("l0", "trying pairs of intervals"), count):
            u, supports = pairs
            way = np.ones(len(u))
            pool = join(ended, polish(task, u, supports, way, method("l0", "polishing")))

    if not reached_first:
        pool = join(pool, _resting(task))
    if task.goal.kind != "l1" and reached_first:
        # Random starts end up far apart, where a torque limit that binds leaves no room for that.
        # As many intervals at both ends may take less effort, so they compete, too.
        most = _most(task, pool)
        bursts = method("l0", "trying bursts at both ends")
        if most > _COMPARED and (ends := fewest_bang_off_bang(task, most + 1, bursts)) is not None:
            pool = join(pool, ends)
            if (between := one_between(task, ends, bursts)) is not None:
                pool = join(pool, between)
    if task.goal.kind != "l1":
        moving = method("l0", "moving single intervals")
        order = pool.order(reached_first)[:_IMPROVED]
        usable = [i for i in order if pool.verdict.reached[i] or not reached_first]
        tried: set[bytes] = set()
        pool = join(pool, *(improve(task, pool.pick(index), moving, tried) for index in usable))
        if reached_first and usable and _most(task, pool) > _COMPARED:
            best = pool.pick(pool.order(True)[0])
            pool = join(pool, merge(task, best, moving, tried))
    return chosen(task, ended, pool)


def chosen(task: SparseTask, starts: Candidates, pool: Candidates) -> Found:
    """Choose the best of a pool of answers; with the printed cost, rest is one of them."""
    reached_first = task.goal.terminal == "reach"
    do_nothing_cost = None
    if not reached_first:
        resting = _resting(task)
        do_nothing_cost = float(resting.rank[0, 0])
        pool = join(pool, resting)
    best = pool.pick(pool.order(reached_first)[0])
    first = pool.pick(pool.order(True)[0])
    reaching = first if bool(first.verdict.reached[0]) else None
    return Found(starts, best, reaching, _distinct(task, starts), do_nothing_cost)


def look(task: SparseTask, count: int, seed: int) -> Candidates:
    """Answers of `count` starts, without rescue, exchange or improvement."""
    decides = "l1" if task.goal.kind == "l1" else "l0"
    rows = chunk_for(count)
    if task.system.decided_by is DecidedBy.BOUNDS:
        return from_bounded_starts(task, count, seed, None, lambda d, _: Method(d, rows=rows))
    method = Method(decides, rows=rows)
    return _ended(task, _drawn(task, method, count, seed, None), method, method)


def _ended(task: SparseTask, starts: Starts, deciding: Method, polishing: Method) -> Candidates:
    """Answers of starts, each on the support that it decided."""
    u, supports = decide(task, starts, deciding)
    ended = polish(task, u, supports, starts.sign, polishing)
    # With several controls, and so more to be spread, bursts at both ends do better and sooner.
    if task.size > 1 or not polishing.spends_least_for(task):
        return ended
    return with_fewer_intervals(task, ended, polishing)


def _most(task: SparseTask, pool: Candidates) -> int:
    """Active intervals of the best answer; half of all where none reaches."""
    best = pool.order(True)[0]
    if not pool.verdict.reached[best]:
        return task.intervals // 2
    return int(support_of(task, pool.controls[best]).any(axis=-1).sum())


def _drawn(task: SparseTask, method: Method, count: int, seed: int, guess: Floats | None) -> Starts:
    """Random pulses, or torques that allow for how the system moves without them."""
    starts = draw(seed, count, task.intervals, task.size, task.long_way_probability(), guess)
    spends = task.in_motion and method.decides == "l1"
    if guess is not None or not (method.follows(task) or spends):
        return starts
    u, way = task.moving_starts(count, seed)
    return starts._replace(u=u, sign=way)


def _pairs(task: SparseTask, method: Method, count: int) -> tuple[Floats, Mask] | None:
    return from_pairs(task, method, count) if method.reweights_for(task) else None


def _distinct(task: SparseTask, candidates: Candidates) -> int:
    seen = set()
    for index in np.flatnonzero(candidates.verdict.reached):
        support = support_of(task, candidates.controls[index])
        effort = task.l1_effort(candidates.controls[index : index + 1])[0]
        seen.add((support.tobytes(), f"{effort:.3g}"))
    return len(seen)


def _resting(task: SparseTask) -> Candidates:
    """The answer without torque, which a printed cost may prefer."""
    nothing = np.zeros((1, task.intervals, task.size))
    status = np.array([int(Status.FEASIBLE)])
    return evaluate(task, nothing, status, np.zeros(1, int), np.ones(1))
