"""Fewer active intervals by reweighted least effort, within the limits of the controls.

Where limits bind in many intervals, weighted steps of least norm leave many of them active.  The
least sum of magnitudes keeps the limits itself.  So it is found again and again from each answer,
with effort as dear in every interval as little of it was used there: what is hardly used ends.

Source: Candes, Wakin and Boyd (2008), "Enhancing sparsity by reweighted l1 minimization".
"""

from __future__ import annotations

import numpy as np

from jaxatt.optimize.reweighting.weights import SUPPORT_THRESHOLD
from jaxatt.problems.hands_off.search.batch import broadcast_lanes
from jaxatt.problems.hands_off.search.candidates import Candidates
from jaxatt.problems.hands_off.search.polish import Method, effort_arguments, polish, spending
from jaxatt.problems.hands_off.task import SparseTask

_LEAST_USED = (0.3, 0.1, 0.03, 0.01)
"""Share of the limits below which effort becomes no dearer, round by round."""


def reweighted(task: SparseTask, candidates: Candidates, method: Method) -> Candidates:
    """Answers on supports that reweighted least effort decides, one from each candidate."""
    arguments, free = effort_arguments(task), np.asarray(task.arguments.free)
    weight = np.asarray(task.arguments.weight)[None]
    solver, kind = spending(task, method)
    u = task.from_controls(candidates.controls)
    for least in _LEAST_USED:
        used = np.linalg.norm(u, axis=-1)
        price = weight * (least + used.max(axis=1, keepdims=True)) / (least + used)
        lanes = broadcast_lanes(u, free, task.arguments.row_weight, candidates.sign, price)
        u = np.nan_to_num(np.asarray(method.run(task, solver, kind, lanes, arguments).x))
    supports = np.abs(u).max(axis=-1, keepdims=True) > SUPPORT_THRESHOLD
    return polish(task, u, supports, candidates.sign, method)
