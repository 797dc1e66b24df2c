"""Local search over supports: drop and move single intervals."""

from __future__ import annotations

import numpy as np

from jaxatt.multistart.candidates import Candidates, better, support_of
from jaxatt.multistart.polish import Method, polish
from jaxatt.optimize.support import neighbours
from jaxatt.problems.task import Task

_ROUNDS = 12


def improve(task: Task, candidate: Candidates, method: Method) -> Candidates:
    """Drop and move single intervals of a support for as long as that makes it better."""
    allowed = np.asarray(task.arguments.free)[:, : 1 if task.shared else None] > 0
    reached_first = task.goal.terminal == "reach"
    for _ in range(_ROUNDS):
        support = support_of(task, candidate.controls[0])
        supports = neighbours(support, allowed)
        if not supports:
            break
        masks = np.stack(supports)
        u = task.from_controls(candidate.controls[0])
        lost = (u[None] * ~masks).sum(axis=1, keepdims=True)
        u = u[None] * masks + lost * (masks & ~support[None])
        moved = polish(task, u, masks, np.repeat(candidate.sign, len(masks)), method)
        best = moved.pick(moved.order(reached_first)[0])
        arrived = bool(best.verdict.reached[0]) or not reached_first
        if not (arrived and better(best.rank[0], candidate.rank[0])):
            break
        candidate = best
    return candidate
