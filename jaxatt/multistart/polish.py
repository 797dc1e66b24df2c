"""From starts to supports, and from supports to the least effort on them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import jax.numpy as jnp
import numpy as np

from jaxatt.multistart.batch import Form, Lanes, Progress, broadcast_lanes, solve_lanes
from jaxatt.multistart.candidates import Candidates, evaluate
from jaxatt.multistart.starts import Starts
from jaxatt.optimize.augmented_lagrangian import Schedule
from jaxatt.optimize.support import Mask
from jaxatt.problems.hands_off import SparseArguments
from jaxatt.problems.task import Floats, Task
from jaxatt.simulation.chunks import CHUNK

HOMOTOPY = Schedule(
    smoothing_start=0.1,
    smoothing_end=1e-4,
    smoothing_factor=0.587,
    max_inner=1,
    max_iterations=14,
    update_multipliers=0.0,
)
"""Reweighting: one Newton step a smoothing, constraints as penalties."""

POLISH = Schedule(
    stage_penalty=1e3, smoothing_start=0.03, smoothing_end=1e-4, max_inner=4, max_iterations=60
)
"""Least effort on a frozen support, to the full tolerance."""

SCREEN = replace(POLISH, max_iterations=30)
"""As `POLISH`, but soon given up: most neighbours of a good support lead nowhere."""

SLACK = Schedule(
    penalty=1e3, smoothing_start=3.0, smoothing_end=1e-2, max_inner=15, max_iterations=300
)
"""The L1 problem with slacks, whose objective is linear: more inner steps, a softer start."""

_SUPPORT_THRESHOLD = 1e-3


@dataclass(frozen=True)
class Method:
    """How a task is solved.

    decides : "l0" or "l1", what decides the support.  inner : name of the inner minimiser.
    rows : starts in one compiled call.  progress : called with the number of starts just ended.
    """

    decides: str
    inner: str = "gauss-newton"
    rows: int = CHUNK
    progress: Progress | None = None


def count_arguments(task: Task) -> SparseArguments:
    """Arguments with which the count of active intervals is minimised."""
    return replace(task.arguments, count_scale=jnp.asarray(task.sparsity_weight))


def effort_arguments(task: Task) -> SparseArguments:
    """Arguments with which the L1 effort is minimised."""
    scale = task.effort_weight if task.goal.terminal == "penalty" else 1.0
    return replace(task.arguments, count_scale=jnp.asarray(0.0), effort_scale=jnp.asarray(scale))


def _free(task: Task, support: Mask) -> Floats:
    """Variables free on a support (..., N, g), without those that are forbidden."""
    full = np.broadcast_to(support, (*support.shape[:-1], task.size))
    return full * np.asarray(task.arguments.free)


def decide(task: Task, starts: Starts, method: Method) -> tuple[Floats, Mask]:
    """Scaled controls and the support they suggest, one for every start."""
    count = len(starts.u)
    free = np.broadcast_to(np.asarray(task.arguments.free), starts.u.shape)
    weight = np.asarray(task.arguments.weight)
    if weight.min() < weight.max():
        cheap = (weight < weight.max())[None, :, None]
        free = np.where(starts.confined[:, None, None], free * cheap, free)
    rows = np.broadcast_to(np.asarray(task.arguments.row_weight), (count, task.rows)).copy()
    rows[::2] = np.inf  # the printed cost may prefer standing still: half the starts must arrive
    slacks = method.decides == "l1"
    form = Form(task.system, task.shared, slacks, method.inner)
    solution = solve_lanes(
        form,
        Lanes(starts.u * free, free, rows, starts.sign),
        effort_arguments(task) if slacks else count_arguments(task),
        SLACK if slacks else HOMOTOPY,
        method.progress,
        method.rows,
    )
    u = np.nan_to_num(solution.x)
    size = np.abs(u).max(axis=-1, keepdims=True) if task.shared else np.abs(u)
    return u, size > _SUPPORT_THRESHOLD


def polish(
    task: Task,
    u: Floats,
    supports: Mask,
    sign: Floats,
    method: Method,
    schedule: Schedule = POLISH,
) -> Candidates:
    """Spend the least on frozen supports (S, N, g), from u (S, N, b), and fly the answers."""
    free = _free(task, supports)
    slacks = method.decides == "l1"
    solution = solve_lanes(
        Form(task.system, task.shared, slacks, method.inner),
        broadcast_lanes(u * free, free, task.arguments.row_weight, sign),
        effort_arguments(task),
        SLACK if slacks else schedule,
        method.progress,
        method.rows,
    )
    x, status, iterations = (
        np.asarray(leaf) for leaf in (solution.x, solution.status, solution.iterations)
    )
    return evaluate(task, x, status, iterations, sign)
