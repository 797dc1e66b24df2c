"""Multi-start search for the sparsest control: decide a support, polish on it, move it, verify.

1. From every start a homotopy of reweighted Newton steps decides which intervals are active.
2. The support is frozen and the L1 effort is minimised on it, with all constraints.
3. The best supports found are improved by dropping and moving single intervals.
4. Every answer is flown again; only those flights are ranked and reported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from jaxatt.multistart.batch import Lanes, Progress, broadcast_lanes, solve_lanes
from jaxatt.multistart.starts import Starts, draw
from jaxatt.optimize.augmented_lagrangian import Schedule
from jaxatt.optimize.status import Status
from jaxatt.optimize.support import Mask, neighbours
from jaxatt.problems.hands_off import SparseArguments
from jaxatt.problems.task import Floats, Task, Verdict

HOMOTOPY = Schedule(
    smoothing_start=0.1,
    smoothing_end=1e-4,
    smoothing_factor=0.587,
    max_inner=1,
    max_iterations=14,
    update_multipliers=0.0,
)
POLISH = Schedule(
    stage_penalty=1e3, smoothing_start=0.03, smoothing_end=1e-4, max_inner=4, max_iterations=60
)
EFFORT = Schedule(smoothing_start=0.1, smoothing_end=1e-5, max_inner=8, max_iterations=150)

_SUPPORT_THRESHOLD = 1e-3
_ROUNDS = 12
_IMPROVED = 2

Report = Callable[[str, int], None]
"""(stage, starts that have just ended), called by the host between chunks."""


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
        """Some of the candidates, or one (S = 1)."""
        rows = np.atleast_1d(index)
        return Candidates(
            self.controls[rows],
            self.status[rows],
            self.verdict.pick(rows),
            self.rank[rows],
            self.iterations[rows],
            self.sign[rows],
        )


def join(*parts: Candidates) -> Candidates:
    """One set of candidates out of several."""
    return Candidates(
        np.concatenate([p.controls for p in parts]),
        np.concatenate([p.status for p in parts]),
        Verdict.join([p.verdict for p in parts]),
        np.concatenate([p.rank for p in parts]),
        np.concatenate([p.iterations for p in parts]),
        np.concatenate([p.sign for p in parts]),
    )


@dataclass(frozen=True)
class Found:
    """Outcome of a search.

    starts : one candidate a start.  best : the answer (S = 1), maybe better than every start.
    reaching : the best that reaches the target, None if nothing does.
    distinct_minima : different answers among the starts that reached the target.
    """

    starts: Candidates
    best: Candidates
    reaching: Candidates | None
    distinct_minima: int


def support_of(task: Task, controls: Floats) -> Mask:
    """Active groups of one control history, (N, g): g = 1 when an interval counts as one."""
    active = np.abs(controls) > task.threshold
    return active.any(axis=-1, keepdims=True) if task.shared else active


def _rank(task: Task, controls: Floats, cost: Floats | None) -> Floats:
    weight = np.asarray(task.arguments.weight)[:, None]
    supports = np.stack([support_of(task, c) for c in controls])
    count = supports.sum(axis=(1, 2)).astype(float)
    effort = task.effort(controls)
    if cost is not None:
        return np.stack([cost, count, effort], axis=1)
    if task.goal.kind == "l1":
        return np.stack([effort, count, effort], axis=1)
    weighted = (weight * supports).sum(axis=(1, 2))
    return np.stack([weighted, count, effort], axis=1)


def evaluate(
    task: Task,
    u: Floats,
    status: npt.NDArray[np.int64],
    iterations: npt.NDArray[np.int64],
    sign: Floats,
) -> Candidates:
    """Turn scaled variables into candidates: flown, judged and ranked."""
    controls = task.to_controls(np.nan_to_num(u))
    verdict, parts = task.verify(controls)
    cost = sum(parts.values()) if task.goal.terminal == "penalty" else None
    lost = ~np.isfinite(u).all(axis=(1, 2))
    status = np.where(lost, int(Status.NOT_FINITE), status)
    return Candidates(controls, status, verdict, _rank(task, controls, cost), iterations, sign)


def _settings(task: Task, stage: str) -> SparseArguments:
    """Arguments of a stage: "count" decides a support, "effort" spends the least on one."""
    soft = task.goal.terminal == "penalty"
    if stage == "count":
        return replace(task.arguments, count_scale=jnp.asarray(task.sparsity_weight))
    scale = task.effort_weight if soft else 1.0
    return replace(task.arguments, count_scale=jnp.asarray(0.0), effort_scale=jnp.asarray(scale))


def _free(task: Task, support: Mask) -> Floats:
    """Variables free on a support (..., N, g), without those that are forbidden."""
    return np.broadcast_to(support, (*support.shape[:-1], task.size)) * np.asarray(
        task.arguments.free
    )


def polish(
    task: Task, u: Floats, supports: Mask, sign: Floats, inner: str, progress: Progress | None
) -> Candidates:
    """Spend the least effort on frozen supports (S, N, g), from u (S, N, b)."""
    free = _free(task, supports)
    lanes = broadcast_lanes(u * free, free, task.arguments.row_weight, sign)
    solution = solve_lanes(
        task.system, task.shared, lanes, _settings(task, "effort"), POLISH, inner, progress
    )
    return evaluate(task, solution.x, solution.status, solution.iterations, sign)


def decide(
    task: Task, starts: Starts, kind: str, inner: str, progress: Progress | None
) -> tuple[Floats, Mask]:
    """Scaled controls and the supports they suggest, one for every start.

    kind : "l1" to let the L1 effort decide, otherwise the count does.
    """
    count = len(starts.u)
    free = np.broadcast_to(np.asarray(task.arguments.free), starts.u.shape)
    weight = np.asarray(task.arguments.weight)
    if weight.min() < weight.max():
        cheap = (weight < weight.max())[None, :, None]
        free = np.where(starts.confined[:, None, None], free * cheap, free)
    rows = np.broadcast_to(np.asarray(task.arguments.row_weight), (count, task.rows)).copy()
    rows[::2] = np.inf  # the printed cost prefers standing still: half the starts must arrive
    stage, schedule = ("effort", EFFORT) if kind == "l1" else ("count", HOMOTOPY)
    lanes = Lanes(starts.u * free, free, rows, starts.sign)
    solution = solve_lanes(
        task.system, task.shared, lanes, _settings(task, stage), schedule, inner, progress
    )
    size = np.abs(np.nan_to_num(solution.x))
    if task.shared:
        size = size.max(axis=-1, keepdims=True)
    return np.nan_to_num(solution.x), size > _SUPPORT_THRESHOLD


def _better(a: Floats, b: Floats) -> bool:
    """Whether rank a is smaller than rank b beyond rounding."""
    margin = 1e-7 * np.maximum(1.0, np.abs(b))
    for x, y, m in zip(a, b, margin, strict=True):
        if abs(x - y) > m:
            return bool(x < y)
    return False


def improve(task: Task, candidate: Candidates, inner: str, progress: Progress | None) -> Candidates:
    """Drop and move single intervals of a support for as long as that makes it better."""
    allowed = np.asarray(task.arguments.free)[:, : 1 if task.shared else None] > 0
    for _ in range(_ROUNDS):
        support = support_of(task, candidate.controls[0])
        supports = neighbours(support, allowed)
        if not supports:
            return candidate
        masks = np.stack(supports)
        u = task.from_controls(candidate.controls[0])
        lost = (u[None] * ~masks).sum(axis=1, keepdims=True)
        u = u[None] * masks + lost * (masks & ~support[None])
        sign = np.repeat(candidate.sign, len(masks))
        moved = polish(task, u, masks, sign, inner, progress)
        reached_first = task.goal.terminal == "reach"
        best = moved.pick(moved.order(reached_first)[0])
        arrived = bool(best.verdict.reached[0]) or not reached_first
        if not (arrived and _better(best.rank[0], candidate.rank[0])):
            return candidate
        candidate = best
    return candidate


def _distinct(task: Task, candidates: Candidates) -> int:
    seen = set()
    for index in np.flatnonzero(candidates.verdict.reached):
        support = support_of(task, candidates.controls[index])
        effort = task.effort(candidates.controls[index : index + 1])[0]
        seen.add((support.tobytes(), f"{effort:.3g}"))
    return len(seen)


def search(
    task: Task,
    count: int,
    seed: int,
    guess: Floats | None = None,
    inner: str = "gauss-newton",
    report: Report | None = None,
) -> Found:
    """Find the best control of a task from `count` starts.

    guess : (N, b), the system's controls to start from; random pulses without it.
    """
    scaled = None if guess is None else task.from_controls(guess)
    starts = draw(seed, count, task.intervals, task.size, task.long_way_probability(), scaled)

    def progress(stage: str) -> Progress | None:
        return None if report is None else lambda done: report(stage, done)

    ended = _from_starts(task, starts, task.goal.kind, inner, progress)
    if task.goal.kind != "l1" and not ended.verdict.reached.any():
        # Where counting leads nowhere, the L1 optimum is the source's own guess for the support.
        rescued = _from_starts(task, starts, "l1", inner, progress)
        if rescued.verdict.reached.any():
            ended = rescued
    reached_first = task.goal.terminal == "reach"
    pool = ended
    if not reached_first:
        pool = join(ended, _resting(task))
    if task.goal.kind != "l1":
        order = pool.order(reached_first)
        rest = [
            improve(task, pool.pick(index), inner, progress("moving single intervals"))
            for index in order[:_IMPROVED]
            if pool.verdict.reached[index] or not reached_first
        ]
        pool = join(pool, *rest)
    best = pool.pick(pool.order(reached_first)[0])
    first = pool.pick(pool.order(True)[0])
    reaching = first if bool(first.verdict.reached[0]) else None
    return Found(ended, best, reaching, _distinct(task, ended))


def _from_starts(
    task: Task,
    starts: Starts,
    kind: str,
    inner: str,
    progress: Callable[[str], Progress | None],
) -> Candidates:
    u, supports = decide(task, starts, kind, inner, progress("deciding which intervals are active"))
    return polish(task, u, supports, starts.sign, inner, progress("polishing"))


def _resting(task: Task) -> Candidates:
    """The answer that does nothing, which a printed cost may prefer."""
    nothing = np.zeros((1, task.intervals, task.size))
    status = np.array([int(Status.FEASIBLE)])
    return evaluate(task, nothing, status, np.zeros(1, int), np.ones(1))
