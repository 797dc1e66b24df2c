"""Compile the programs of a search ahead and in parallel."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np

from jaxatt.multistart.driver import begin_compiling
from jaxatt.problems.hands_off.search.batch import Form, broadcast_lanes
from jaxatt.problems.hands_off.search.polish import (
    Method,
    count_arguments,
    effort_arguments,
    reweighting,
    spending,
)
from jaxatt.problems.hands_off.search.shared_lengths import lengthened, lengthening
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.chunks import cores


@contextmanager
def compiled_ahead(task: SparseTask, method: Method, count: int) -> Iterator[None]:
    """Start compiling what `decide`, `polish` and the flights of `count` starts run; wait for it
    at the end.

    Of slews by pulses to a target all of it, in the order in which it is needed; of others only the
    flights.
    """
    with ThreadPoolExecutor(cores(), thread_name_prefix="jaxatt-compile") as pool:
        if method.spends_least_for(task):
            arguments = task.arguments
            u = np.zeros((method.rows, task.intervals, task.size))
            lanes = broadcast_lanes(u, arguments.free, arguments.row_weight, np.ones(len(u)))
            for (solver, kind), needed in (
                (reweighting(task, method, method.deciding(task)), count_arguments(task)),
                (spending(task, method), effort_arguments(task)),
            ):
                form = Form(task.system, task.shared, kind, task.size)
                longer = lengthened(task.system, lanes, needed, lengthening(task, kind))
                begin_compiling(pool, solver, form, *longer, method.rows)
        task.begin_verifying(pool, count)
        yield
