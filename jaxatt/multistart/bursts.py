"""Supports of two bursts, the first and the last intervals: where sparse slews with valves end up.

Torque early and late has the longest lever, so slews that saturate use the ends of the horizon.
Trying every such support of a size is cheap, rescues searches that do not arrive, and is evidence
where none of a smaller size does.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from jaxatt.multistart.candidates import Candidates
from jaxatt.multistart.polish import Method, polish, screen
from jaxatt.optimize.support import Mask
from jaxatt.problems.task import Floats, Task


def burst_supports(task: Task, shapes: Iterable[tuple[int, int]]) -> Mask:
    """Supports (S, N, 1) of the first a and the last b intervals that are allowed."""
    allowed = np.flatnonzero((np.asarray(task.arguments.free) > 0).any(axis=1))
    made = []
    for first, last in shapes:
        support = np.zeros((task.intervals, 1), bool)
        support[allowed[:first]] = True
        support[allowed[len(allowed) - last :]] = True
        made.append(support)
    return np.unique(np.stack(made), axis=0)


def _both_ways(task: Task, supports: Mask) -> tuple[Floats, Mask, Floats]:
    """Controls at rest, the supports twice, and the way round, 1 then -1."""
    twice = np.concatenate([supports, supports])
    sign = np.repeat([1.0, -1.0], len(supports))
    return np.zeros((len(twice), task.intervals, task.size)), twice, sign


def try_bursts(task: Task, size: int, method: Method) -> Candidates:
    """Every support of `size` intervals in two bursts, both ways round, flown and judged."""
    shapes = [(first, size - first) for first in range(size + 1)]
    return screen(task, *_both_ways(task, burst_supports(task, shapes)), method)


def cheapest_bursts(task: Task, most: int, method: Method) -> Candidates:
    """A first burst of every length up to `most`, alone or with as long a one at the end."""
    shapes = [(first, last) for first in range(1, most + 1) for last in (0, first)]
    return polish(task, *_both_ways(task, burst_supports(task, shapes)), method)
