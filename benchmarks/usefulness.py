"""Which answers count: the same rule for every solver, judged by an independent flight.

A start is *useful* when the flight of its controls with fine steps ends within 0.1 deg and
1e-4 rad/s of the target, no limit is exceeded by more than 1e-9 (N m, or units of the control),
and it has no more active intervals than the best known.  The double integrator has one error, the
distance from its target: below 1e-5, like the others ten times what its scenario tolerates.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats

ALLOWED = {"attitude": float(np.deg2rad(0.1)), "rate": 1e-4, "state": 1e-5}
"""Largest errors at the end: [rad], [rad/s] and units of the toy's state."""

EXCESS = 1e-9
"""Largest excess over a limit, [N m] or units of the toy's control."""


def thresholded(task: SparseTask, controls: Floats) -> Floats:
    """Controls (S, N, b) with intervals whose controls all count as zero set to that."""
    return np.where(task.active(controls).any(axis=-1, keepdims=True), controls, 0.0)


def active_intervals(task: SparseTask, controls: Floats) -> npt.NDArray[np.int64]:
    """Intervals with a control that counts as more than zero, (S,)."""
    return np.asarray(task.active(controls).any(axis=-1).sum(axis=-1))


def reaching(task: SparseTask, controls: Floats) -> npt.NDArray[np.bool_]:
    """(S,) whether the controls (S, N, b) meet the target and the limits when they are flown.

    controls : in the task's axes, [N m] for a slew; not clipped here, so an excess counts.
    """
    flown = thresholded(task, np.nan_to_num(controls, nan=np.inf, posinf=1e3, neginf=-1e3))
    verdict, _ = task.verify(flown)
    within = (verdict.limit_violation <= EXCESS) & (
        verdict.margin_violation <= verdict.MARGIN_TOLERANCE
    )
    for name, error in verdict.errors.items():
        within &= np.nan_to_num(error, nan=np.inf) <= ALLOWED[name]
    return np.asarray(within)


def useful(task: SparseTask, controls: Floats, best_known: int) -> npt.NDArray[np.bool_]:
    """(S,) whether the controls (S, N, b) reach with at most `best_known` active intervals."""
    return reaching(task, controls) & (active_intervals(task, controls) <= best_known)
