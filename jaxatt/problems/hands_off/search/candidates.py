"""Answers with the verdict of their re-simulation, and their ranking."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.reweighting.support import Mask
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.problems.verdict import Verdict
from jaxatt.runtime.arrays import Floats

_ROUNDING = (1e-7, 1e-7, 1e-5)
"""Relative differences of ranks that mean nothing: of costs, counts and efforts."""


@dataclass(frozen=True)
class Candidates:
    """Answers with their verdicts; leading axis S.

    controls : (S, N, b), the system's controls.  status : (S,) `Status`.
    verdict : from re-simulation.  rank : (S, 3), what is compared, smaller is better.
    iterations : (S,), inner steps.  sign : (S,), -1 where the long way round was aimed at.
    """

    controls: Floats
    status: npt.NDArray[np.int64]
    verdict: Verdict
    rank: Floats
    iterations: npt.NDArray[np.int64]
    sign: Floats

    def order(self, reached_first: bool) -> npt.NDArray[np.int64]:
        """Indices from best to worst."""
        keys = list(self.rank.T[::-1])
        if reached_first:
            missed = np.where(self.verdict.reached, 0.0, np.maximum(1.0, self.verdict.shortfall))
            keys.append(missed)
        return np.lexsort(keys)

    def pick(self, index: npt.NDArray[np.int64] | int) -> Candidates:
        """Select some of the candidates, or one (S = 1)."""
        rows = np.atleast_1d(index)
        return Candidates(
            self.controls[rows],
            self.status[rows],
            self.verdict.pick(rows),
            self.rank[rows],
            self.iterations[rows],
            self.sign[rows],
        )

    def where(self, kept: npt.NDArray[np.bool_], others: Candidates) -> Candidates:
        """These candidates where `kept` (S,) is true, and the others elsewhere."""
        count = len(kept)
        return join(self, others).pick(np.where(kept, np.arange(count), count + np.arange(count)))


def join(*parts: Candidates) -> Candidates:
    """Concatenate several sets of candidates."""
    return Candidates(
        np.concatenate([p.controls for p in parts]),
        np.concatenate([p.status for p in parts]),
        Verdict.join([p.verdict for p in parts]),
        np.concatenate([p.rank for p in parts]),
        np.concatenate([p.iterations for p in parts]),
        np.concatenate([p.sign for p in parts]),
    )


def support_of(task: SparseTask, controls: Floats) -> Mask:
    """Active groups of one control history, (N, g); g = 1 where an interval counts as one."""
    active = task.active(controls)
    return np.any(active, axis=-1, keepdims=True) if task.shared else active


def _rank(task: SparseTask, controls: Floats, cost: Floats | None) -> Floats:
    weight = np.asarray(task.arguments.weight)[:, None]
    supports = np.stack([support_of(task, c) for c in controls])
    count = supports.sum(axis=(1, 2)).astype(float)
    effort = task.l1_effort(controls)
    if cost is not None:
        return np.stack([cost, count, effort], axis=1)
    if task.goal.kind == "l1":
        return np.stack([task.slack_sum(controls), count, effort], axis=1)
    weighted = (weight * supports).sum(axis=(1, 2))
    return np.stack([weighted, count, effort], axis=1)


def evaluate(
    task: SparseTask,
    u: Floats,
    status: npt.NDArray[np.int64],
    iterations: npt.NDArray[np.int64],
    sign: Floats,
) -> Candidates:
    """Fly scaled variables, judge and rank them."""
    controls = task.to_controls(np.nan_to_num(u))
    verdict, parts = task.verify(controls)
    cost = np.sum(list(parts.values()), axis=0) if task.goal.terminal == "penalty" else None
    lost = ~np.isfinite(u).all(axis=(1, 2))
    status = np.where(lost, int(Status.NOT_FINITE), status)
    return Candidates(controls, status, verdict, _rank(task, controls, cost), iterations, sign)


def better(a: Floats, b: Floats) -> bool:
    """Whether rank a is smaller than rank b by more than rounding."""
    for x, y, share in zip(a, b, _ROUNDING, strict=True):
        if abs(x - y) > share * abs(y):
            return bool(x < y)
    return False
