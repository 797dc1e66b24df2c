"""Enumeration of supports, tried in batches, as evidence for minimality.

Supports are grouped in classes by how many active groups of each weight they have, so that those
which cost less than a known answer can be told from those which cost as much.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.optimize.reweighting.support import Mask
from jaxatt.optimize.reweighting.weights import Reweighting
from jaxatt.problems.hands_off.search.batch import broadcast_lanes
from jaxatt.problems.hands_off.search.polish import (
    SCREENING,
    SETTLE_ROLL,
    SETTLED,
    Method,
    polish,
    reweight,
)
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Flags, Floats

_FROM_REST = Reweighting(deciding=0, settling=10)
_WITH_ROLL = Reweighting(deciding=0, settling=SETTLE_ROLL, settled_smoothing=0.03)
"""The same where a roll has to settle; with less smoothing it still creeps after many steps."""
_PER_CALL = 4096
_MOST_PAIRS = 20_000
_RELATIVE_TIE = 1e-9


@dataclass(frozen=True)
class SupportClass:
    """Supports with the same number of active groups of each weight.

    weights : the different weights of groups.  counts : active groups of each.
    available : groups of each that may be active.
    """

    weights: tuple[float, ...]
    counts: tuple[int, ...]
    available: tuple[int, ...]

    @property
    def size(self) -> int:
        """Number of active groups."""
        return sum(self.counts)

    @property
    def cost(self) -> float:
        """Weighted count."""
        return sum(w * c for w, c in zip(self.weights, self.counts, strict=True))

    @property
    def number(self) -> int:
        """Number of supports in the class."""
        return math.prod(math.comb(n, c) for n, c in zip(self.available, self.counts, strict=True))


@dataclass(frozen=True)
class Enumerated:
    """Outcome of trying supports one way round; leading axis S.

    groups : (S, K, 2), interval and group of every active group.
    reached : (S,), whether the roll-out meets the target within limits.
    effort : (S,), L1 effort where it does, nan elsewhere.
    residual : (S,), what Newton's method left.  seconds : wall clock.
    """

    groups: npt.NDArray[np.int64]
    reached: Flags
    effort: Floats
    residual: Floats
    seconds: float


def group_weights(task: SparseTask) -> Floats:
    """Weight of every group, (N, g); nan where no control is allowed."""
    groups = 1 if task.shared else task.size
    weight = np.broadcast_to(np.asarray(task.arguments.weight)[:, None], (task.intervals, groups))
    allowed = np.asarray(task.arguments.free)[:, :groups] > 0
    return np.where(allowed, weight, np.nan)


def classes_up_to(task: SparseTask, cost: float) -> list[SupportClass]:
    """All classes of supports that cost at most `cost`, the cheapest first."""
    weight = group_weights(task)
    levels, available = np.unique(weight[~np.isnan(weight)], return_counts=True)
    most = [
        min(n, math.floor(cost / w * (1.0 + _RELATIVE_TIE)))
        for w, n in zip(levels, available, strict=True)
    ]
    found = [
        SupportClass(tuple(levels.tolist()), counts, tuple(available.tolist()))
        for counts in itertools.product(*(range(m + 1) for m in most))
    ]
    limit = cost * (1.0 + _RELATIVE_TIE)
    return sorted((c for c in found if c.cost <= limit), key=lambda c: (c.cost, c.size))


def _supports(task: SparseTask, kind: SupportClass) -> Iterator[list[tuple[int, int]]]:
    weight = group_weights(task)
    places = [[(int(k), int(g)) for k, g in np.argwhere(weight == w)] for w in kind.weights]
    choices = [itertools.combinations(p, c) for p, c in zip(places, kind.counts, strict=True)]
    for parts in itertools.product(*map(list, choices)):
        yield sorted(itertools.chain.from_iterable(parts))


def masks_of(task: SparseTask, groups: npt.NDArray[np.int64]) -> Mask:
    """Masks (S, N, g) of supports given by their active groups (S, K, 2)."""
    masks: Mask = np.zeros((len(groups), task.intervals, 1 if task.shared else task.size), bool)
    for column in range(groups.shape[1]):
        masks[np.arange(len(groups)), groups[:, column, 0], groups[:, column, 1]] = True
    return masks


def try_supports(
    task: SparseTask,
    groups: npt.NDArray[np.int64],
    sign: float,
    method: Method,
    u: Floats | None = None,
) -> tuple[Floats, Floats, Flags]:
    """Minimise effort on supports (S, K, 2): controls (S, N, b) and residuals (S,).

    u : first controls; at rest without them.  The flags (S,) say where a limit binds.
    """
    free = masks_of(task, groups) * np.asarray(task.arguments.free)[None]
    first = np.zeros_like(free) if u is None else u * free
    lanes = broadcast_lanes(first, free, np.full(task.rows, np.inf), np.asarray(sign))
    settings = _WITH_ROLL if task.leaves_roll_free else _FROM_REST
    found = reweight(task, lanes, method, settings)
    residual = np.nan_to_num(np.asarray(found.residual), nan=np.inf)
    return np.asarray(found.u), residual, np.asarray(found.saturated)


def enumerate_class(
    task: SparseTask,
    kind: SupportClass,
    sign: float,
    method: Method,
    attempts: int = 1,
    seed: int = 0,
    thorough: bool = False,
) -> Enumerated:
    """Try every support of a class, one way round.

    sign : 1 for the short way round to the target, -1 for the long one.
    attempts : starting points of every support; beyond the first they are random.
    thorough : whether supports on which limits bind and Newton's method does not arrive are tried
        by the full polish too, and flown.
    """
    began = time.perf_counter()
    rng = np.random.default_rng(seed)
    parts = []
    listed = _supports(task, kind)
    while batch := list(itertools.islice(listed, _PER_CALL)):
        groups = np.asarray(batch, np.int64).reshape(len(batch), kind.size, 2)
        tried = try_supports(task, groups, sign, method)
        u, residual, saturated = tried[0].copy(), tried[1].copy(), tried[2].copy()
        for _ in range(attempts - 1):
            left = np.flatnonzero(residual > SETTLED)
            if not len(left):
                break
            random = rng.uniform(-1.0, 1.0, (len(left), task.intervals, task.size))
            again, rest, bound = try_supports(task, groups[left], sign, method, random)
            better = left[rest < residual[left]]
            u[better], residual[better] = again[rest < residual[left]], rest[rest < residual[left]]
            saturated[left] |= bound
        reached = residual <= SETTLED
        effort = np.where(reached, task.l1_effort(task.to_controls(np.nan_to_num(u))), np.nan)
        stuck = np.flatnonzero(~reached & saturated)
        if thorough and len(stuck):
            nothing = np.zeros((len(stuck), task.intervals, task.size))
            way = np.full(len(stuck), sign)
            ended = polish(task, nothing, masks_of(task, groups[stuck]), way, method, SCREENING)
            reached[stuck] = ended.verdict.reached
            effort[stuck] = np.where(ended.verdict.reached, ended.rank[:, -1], np.nan)
        parts.append((groups, reached, effort, residual))
    joined = [np.concatenate(leaves) for leaves in zip(*parts, strict=True)]
    return Enumerated(joined[0], joined[1], joined[2], joined[3], time.perf_counter() - began)


def from_pairs(task: SparseTask, method: Method, count: int) -> tuple[Floats, Mask] | None:
    """The `count` pairs of groups that reach with least effort: controls and supports.

    Where an answer needs so little torque that pulses far apart fall below the threshold, random
    starts, which end up far apart, do not find it.  None if no pair reaches.
    """
    weight = group_weights(task)
    places = [(int(k), int(g)) for k, g in np.argwhere(~np.isnan(weight))]
    if not 0 < math.comb(len(places), 2) <= _MOST_PAIRS:
        return None
    groups = np.asarray(list(itertools.combinations(places, 2)), np.int64)
    u, residual, _ = try_supports(task, groups, 1.0, method)
    controls = task.to_controls(np.nan_to_num(u))
    kept = (np.abs(controls).max(axis=-1) > 0.0).sum(axis=1) >= 2
    usable = np.flatnonzero((residual <= SETTLED) & kept)
    if not len(usable):
        return None
    best = usable[np.argsort(task.l1_effort(controls[usable]))[:count]]
    return u[best], masks_of(task, groups[best])
