"""Local search over supports: drop and move single intervals, let one do what two did."""

from __future__ import annotations

import numpy as np

from jaxatt.optimize.reweighting.support import Mask, mergers, neighbours
from jaxatt.problems.hands_off.search.candidates import Candidates, better, support_of
from jaxatt.problems.hands_off.search.polish import Method, polish, screen
from jaxatt.problems.hands_off.task import SparseTask

_ROUNDS = 12
_MERGED = 128
"""Mergers tried of one answer."""
_MERGED_UP_TO = 16
"""Active groups up to which mergers are tried; of more groups there are too many mergers."""


def improve(
    task: SparseTask, candidate: Candidates, method: Method, tried: set[bytes]
) -> Candidates:
    """Drop and move single intervals of a support while that improves the answer.

    tried : supports that were polished before and need not be again; grows as the search goes on.
    """
    allowed = _allowed(task)
    for _ in range(_ROUNDS):
        near = neighbours(support_of(task, candidate.controls[0]), allowed)
        found = _best_of(task, candidate, near, method, tried)
        if found is None:
            break
        candidate = found
    return _finished(task, candidate, method)


def merge(task: SparseTask, candidate: Candidates, method: Method, tried: set[bytes]) -> Candidates:
    """Let one interval do what two did, anywhere, and improve that, for as long as some reach.

    Moves of single intervals end where none is better by itself; there two may still make room
    for one.  tried : see `improve`.
    """
    while True:
        support = support_of(task, candidate.controls[0])
        if support.sum() > _MERGED_UP_TO:
            return candidate
        found = _best_of(task, candidate, mergers(support, _allowed(task), _MERGED), method, tried)
        if found is None:
            return candidate
        candidate = improve(task, found, method, tried)


def _allowed(task: SparseTask) -> Mask:
    return np.asarray(task.arguments.free)[:, : 1 if task.shared else None] > 0


def _best_of(
    task: SparseTask,
    candidate: Candidates,
    supports: list[Mask],
    method: Method,
    tried: set[bytes],
) -> Candidates | None:
    """Best answer on other supports; None where it is no better than the candidate."""
    supports = [s for s in supports if s.tobytes() not in tried]
    if not supports:
        return None
    tried.update(s.tobytes() for s in supports)
    reached_first = task.goal.terminal == "reach"
    support, masks = support_of(task, candidate.controls[0]), np.stack(supports)
    u = task.from_controls(candidate.controls[0])
    lost = (u[None] * ~masks).sum(axis=1, keepdims=True)
    u = u[None] * masks + lost * (masks & ~support[None])
    found = screen(task, u, masks, np.repeat(candidate.sign, len(masks)), method)
    best = found.pick(found.order(reached_first)[0])
    arrived = bool(best.verdict.reached[0]) or not reached_first
    return best if arrived and better(best.rank[0], candidate.rank[0]) else None


def _finished(task: SparseTask, candidate: Candidates, method: Method) -> Candidates:
    """Polish the candidate to full tolerance, where that improves it."""
    support = support_of(task, candidate.controls[0])[None]
    ended = polish(task, task.from_controls(candidate.controls), support, candidate.sign, method)
    arrived = bool(ended.verdict.reached[0]) or task.goal.terminal == "penalty"
    return ended if arrived and better(ended.rank[0], candidate.rank[0]) else candidate
