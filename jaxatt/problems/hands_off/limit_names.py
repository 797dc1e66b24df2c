"""Names of the limits of a sparse answer, for messages."""

from __future__ import annotations

import jax.numpy as jnp

from jaxatt.problems.hands_off.support import Support
from jaxatt.problems.hands_off.task import SparseTask


def margin_names(task: SparseTask, support: Support) -> list[str]:
    """Names of `margins_on`, in its order."""
    if task.system.bounds is not None:
        return list(task.path_names)
    idle = jnp.zeros((1, task.size))
    rows = task.system.stage_margins(idle, task.arguments.plant).shape[1]
    sides = [f"{side} limit {i}" for side in ("upper", "lower") for i in range(rows // 2)]
    return [f"{row}, interval {k}" for k in support.stages for row in sides] + list(task.path_names)


def bound_names(task: SparseTask, support: Support, others: int) -> list[str]:
    """Names of the bounds of `box_on`, lower ones first; those of `others` do not exist."""
    words = {
        "lower": ["shut" if shut else "at its lower limit" for shut in task.one_sided],
        "upper": ["open throughout" if shut else "at its upper limit" for shut in task.one_sided],
    }
    names = []
    for side in ("lower", "upper"):
        names += [f"actuator {j} {words[side][j]}, interval {k}" for k, j in support.places]
        names += [f"{side} bound of variable {i}" for i in range(others)]
    return names
