"""Tasks of several numbers of intervals in one compiled program.

The programme is filled up with intervals that take no time and have no torque.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jaxatt.optimize.reweighting.weights import SparseRoot
from jaxatt.optimize.solution import Solution
from jaxatt.problems.hands_off.search.batch import Lanes
from jaxatt.problems.hands_off.sparse_program import SparseArguments, SparseSystem
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.lengths import held_on, shared_length

_KINDS = ("roots", "effort")
"""Programmes that can be filled up; see `Form`."""
_LONG = 64
"""Intervals beyond which lengths are closer together; see `shared_length`."""


def lengthening(task: SparseTask, kind: str) -> int:
    """Intervals by which a task's programme of a kind is filled up."""
    if not task.shares_programs or task.system.lengthened is None or kind not in _KINDS:
        return 0
    return shared_length(task.intervals, _LONG) - task.intervals


def lengthened(
    system: SparseSystem, lanes: Lanes, arguments: SparseArguments, more: int
) -> tuple[Lanes, SparseArguments]:
    """Fill up starts and arguments with `more` intervals without torque."""
    if not more:
        return lanes, arguments
    assert system.lengthened is not None

    def without_torque(rows: Floats, axis: int) -> Any:
        widths = [(0, more if k == axis else 0) for k in range(rows.ndim)]
        return np.pad(rows, widths)

    longer = lanes._replace(
        u=without_torque(lanes.u, 1),
        free=without_torque(lanes.free, 1),
        price=held_on(lanes.price, more, 1),
    )
    free: Any = np.asarray(arguments.free)
    return longer, replace(
        arguments,
        plant=system.lengthened(arguments.plant, more),
        weight=held_on(arguments.weight, more),
        free=without_torque(free, 0) if free.shape[0] > 1 else free,
        price=held_on(arguments.price, more),
    )


def shortened(found: SparseRoot | Solution, intervals: int) -> SparseRoot | Solution:
    """Results without the intervals that filled the programme up."""
    if isinstance(found, SparseRoot):
        return found._replace(u=found.u[:, :intervals], support=found.support[:, :intervals])
    return found._replace(x=found.x[:, :intervals])
