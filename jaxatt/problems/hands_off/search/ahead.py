"""What a search is going to run, compiled side by side before it is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np

from jaxatt.optimize.reweighting.condensed import Reweighting
from jaxatt.problems.hands_off.search.batch import broadcast_lanes, effort_chunk, sparsify_chunk
from jaxatt.problems.hands_off.search.polish import LEAST, Method, count_arguments, effort_arguments
from jaxatt.problems.hands_off.task import Task
from jaxatt.runtime.chunks import cores


@contextmanager
def compiled_ahead(task: Task, method: Method) -> Iterator[None]:
    """Begin with what `decide`, `polish` and the flights run; at the end nothing is at work.

    Of slews by pulses to a target all of it, in the order in which it is needed; of others only the
    flights.
    """
    with ThreadPoolExecutor(cores(), thread_name_prefix="jaxatt-compile") as pool:
        if method.spends_least_for(task):
            form, arguments = method.form(task), task.arguments
            u = np.zeros((method.rows, task.intervals, task.size))
            lanes = broadcast_lanes(u, arguments.free, arguments.row_weight, np.ones(len(u)))
            sparsify_chunk.begin(pool, form, lanes, count_arguments(task), Reweighting())
            effort_chunk.begin(pool, form, lanes, effort_arguments(task), LEAST)
        task.begin_verifying(pool)
        yield
