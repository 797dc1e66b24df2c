"""Reweighting settings and answers for controls with bounds of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jax import Array

from jaxatt.multistart.driver import run_starts
from jaxatt.optimize.reweighting.bounded import BETWEEN_BOUNDS, BoundedReweighting
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.search.batch import Form, Lanes
from jaxatt.problems.hands_off.search.candidates import Candidates, evaluate
from jaxatt.problems.hands_off.sparse_program import SparseArguments
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.chunks import CHUNK, Progress

DECIDE = BoundedReweighting()
"""Reweighting that decides supports, from scaled controls of any size."""

DECIDE_SLOWLY = BoundedReweighting(replace(BETWEEN_BOUNDS, deciding=24, factor=0.75))
"""The same where path constraints, which are worst now here, now there, have to be met as well."""

SETTLE = BoundedReweighting(
    replace(BETWEEN_BOUNDS, deciding=0, settling=20, settled_smoothing=1e-2)
)
"""Whether a given support leads to the target."""

POLISH = replace(BETWEEN_BOUNDS, deciding=0, settling=40, settled_smoothing=1e-4)
"""The least effort on a given support, to the full tolerance."""

_STILL = 1e-4
"""Largest change of a scaled control in the last step that counts as none."""

_TIGHT = 1e-7
"""Rows before the last step up to which a polished answer can be called converged."""


def polish_bounded(
    task: SparseTask,
    form: Form,
    lanes: Lanes,
    arguments: SparseArguments,
    progress: Progress | None = None,
    rows: int = CHUNK,
) -> Candidates:
    """Minimise effort or printed cost on the lanes' supports, fly and judge the answers.

    Where the printed cost is minimised, the answer with every control on its nearer limit stands
    in for a start where it costs less: the cost punishes partly open thrusters.
    """
    soft = task.goal.terminal == "penalty"
    solver = BoundedReweighting(replace(POLISH, effort=task.effort_weight if soft else 1.0))
    found = run_starts(solver, form, lanes, arguments, rows=rows, progress=progress)
    arrived = np.asarray(found.residual) <= _TIGHT
    still = np.asarray(found.moved) <= _STILL
    status = np.where(
        arrived & still,
        int(Status.CONVERGED),
        np.where(arrived, int(Status.FEASIBLE), int(Status.ITERATION_LIMIT)),
    )
    steps = np.full(len(lanes.u), POLISH.settling)
    settled = evaluate(task, np.asarray(found.u), status, steps, np.asarray(lanes.sign))
    if not soft:
        return settled
    lower, upper = (np.asarray(b) for b in bounds_of(task))
    snapped = _snapped(np.nan_to_num(np.asarray(found.u)), lower, upper)
    feasible = np.full(len(lanes.u), int(Status.FEASIBLE))
    whole = evaluate(task, snapped, feasible, steps, np.asarray(lanes.sign))
    cheaper = whole.rank[:, 0] < settled.rank[:, 0]
    return settled.where(~cheaper, whole)


def bounds_of(task: SparseTask) -> tuple[Array, Array]:
    """Bounds (b,) of a task's scaled controls."""
    bounds = task.system.bounds
    assert bounds is not None
    return bounds(task.arguments.plant)


def _snapped(u: Floats, lower: Floats, upper: Floats) -> Floats:
    """Round every control to the nearest of zero and its limits."""
    levels = np.stack(np.broadcast_arrays(np.zeros_like(u), lower, upper))
    nearest = np.abs(levels - u).argmin(axis=0)
    return np.asarray(np.take_along_axis(levels, nearest[None], axis=0)[0])
