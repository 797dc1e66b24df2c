"""Local search over supports: drop and move single intervals."""

from __future__ import annotations

import numpy as np

from jaxatt.optimize.reweighting.support import neighbours
from jaxatt.problems.hands_off.search.candidates import Candidates, better, support_of
from jaxatt.problems.hands_off.search.polish import Method, polish, screen
from jaxatt.problems.hands_off.task import SparseTask

_ROUNDS = 12


def improve(
    task: SparseTask, candidate: Candidates, method: Method, tried: set[bytes]
) -> Candidates:
    """Drop and move single intervals of a support while that improves the answer.

    tried : supports that were polished before and need not be again; grows as the search goes on.
    """
    allowed = np.asarray(task.arguments.free)[:, : 1 if task.shared else None] > 0
    reached_first = task.goal.terminal == "reach"
    for _ in range(_ROUNDS):
        support = support_of(task, candidate.controls[0])
        supports = [s for s in neighbours(support, allowed) if s.tobytes() not in tried]
        if not supports:
            break
        tried.update(s.tobytes() for s in supports)
        masks = np.stack(supports)
        u = task.from_controls(candidate.controls[0])
        lost = (u[None] * ~masks).sum(axis=1, keepdims=True)
        u = u[None] * masks + lost * (masks & ~support[None])
        moved = screen(task, u, masks, np.repeat(candidate.sign, len(masks)), method)
        best = moved.pick(moved.order(reached_first)[0])
        arrived = bool(best.verdict.reached[0]) or not reached_first
        if not (arrived and better(best.rank[0], candidate.rank[0])):
            break
        candidate = best
    return _finished(task, candidate, method)


def _finished(task: SparseTask, candidate: Candidates, method: Method) -> Candidates:
    """Polish the candidate to full tolerance, where that improves it."""
    support = support_of(task, candidate.controls[0])[None]
    ended = polish(task, task.from_controls(candidate.controls), support, candidate.sign, method)
    arrived = bool(ended.verdict.reached[0]) or task.goal.terminal == "penalty"
    return ended if arrived and better(ended.rank[0], candidate.rank[0]) else candidate
