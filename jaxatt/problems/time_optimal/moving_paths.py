"""Starts of a reorientation of a body in motion, or with wheels that store momentum.

Random shares of the turn at every node (`random_paths`) suit a body at rest.  A spin would have to
stop within one interval of such a path, and stored momentum resists every turn that is taken back.
So a body in motion follows a smooth path (`smooth_paths`), which takes as long as its torques need
to stay within their limits.
"""

from __future__ import annotations

import numpy as np

from jaxatt.attitude.host_turns import product
from jaxatt.problems.smooth_paths import DRAWS, Ends, Shapes, follow, shapes
from jaxatt.problems.time_optimal.paths import Paths, states_along
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats

_LEAST_PART = 0.2
"""Of the time, in which a start may brake or speed up."""
_SPREAD = 0.1
_NEARLY = 1.5
"""Times the least torque of any time, in units of the limits, that is about as near."""
_TIMES = np.geomspace(0.05, 2.0, 40)
"""Times that are tried, in units of a crude one."""


def moving_paths(task: ReorientationTask, count: int, seed: int) -> Paths:
    """Draw starts of a task; start i depends on the seed and on i only."""
    n, goal, ends = task.intervals, task.goal, _ends(task, count)
    size = DRAWS + n * task.actuation.size
    drawn = np.stack([np.random.default_rng((seed, i)).random(size) for i in range(count)])
    shape = shapes(drawn[:, :DRAWS], _LEAST_PART, _LEAST_PART)
    duration = np.clip(_long_enough(task, ends, shape), goal.shortest, goal.longest)
    path = follow(ends, shape, duration, n)
    u = path.torque @ _allocation(task).T
    if goal.effort_weight == 0.0:
        u = u + _SPREAD * (2.0 * drawn[:, DRAWS:] - 1.0).reshape(u.shape)
    u = np.clip(u, task.actuation.lower, task.actuation.upper)
    short = np.sum(path.q[:, -1] * ends.relative[:, 0], axis=1, keepdims=True) >= 0.0
    short |= task.target.boresight is not None  # a free roll makes the ways one
    reference = np.where(short, task.reference(1.0), task.reference(-1.0))
    step = duration / n
    states = states_along(task, product(ends.q, path.q), path.omega, path.momentum, u, step)
    return Paths(u, states, step, reference, np.full(count, goal.effort_weight))


def _ends(task: ReorientationTask, count: int) -> Ends:
    craft, begin, target = task.craft, task.initial_state, task.target.of_starts(count)
    return Ends(
        np.asarray(begin.q_ob),
        np.asarray(begin.omega_ob),
        target.q_ob[:, None],
        target.omega_ob[:, None],
        None if task.form.body.momentum == "own" else task.momentum,
        np.asarray(craft.inertia),
        np.asarray(craft.inertia_without_spin),
    )


def _allocation(task: ReorientationTask) -> Floats:
    """Scaled controls of a torque on the body, (b, 3) [1/(N m)]."""
    return np.asarray(np.linalg.pinv(task.actuation.to_external - task.actuation.to_body))


def _long_enough(task: ReorientationTask, ends: Ends, shape: Shapes) -> Floats:
    """Shortest times (S,) [s] tried at which the torques stay within their limits.

    Where they never do, as where a spin meets stored momentum at either end, the shortest at which
    they come about as near as they get: more time only adds more of the same.
    """
    a, allocation = task.actuation, _allocation(task)
    most = np.maximum(np.abs(a.lower), a.upper)
    weakest = 1.0 / np.abs(allocation / most[:, None]).max()
    inertia = float(np.linalg.eigvalsh(ends.inertia).max())
    spun = inertia * max(np.abs(ends.rate).max(), np.abs(ends.end_rate).max())
    carried = float(np.linalg.norm(task.momentum))
    crude = 2.0 * np.sqrt(np.pi * inertia / weakest) + (spun + np.pi * carried) / weakest
    count = len(shape.brake)
    most_used = np.full((len(_TIMES), count), np.inf)
    for i, time in enumerate(crude * _TIMES):
        torque = follow(ends, shape, np.full(count, time), task.intervals).torque
        most_used[i] = (np.abs(torque @ allocation.T) / most).max(axis=(1, 2))
    allowed = np.maximum(1.0, _NEARLY * most_used.min(axis=0))
    return np.asarray(crude * _TIMES[np.argmax(most_used <= allowed, axis=0)])
