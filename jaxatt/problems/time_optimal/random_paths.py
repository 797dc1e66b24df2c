"""Random feasible starts of a reorientation: a path, its torques and a time for it.

Between the two attitudes every node gets a random share of the turn; the rates and torques of that
path follow from inverse dynamics, and the interval is made long enough for the torques to stay
within their limits.  Source: Sensors and Materials 32 (5), 2020, 1671 ff., section 4, eqs. (27) to
(34); (27) with sigma(1) = sigma(0) and sigma(N) = sigma(N + 1), so that it begins and ends at rest.
"""

from __future__ import annotations

import numpy as np

from jaxatt.attitude import quaternion
from jaxatt.problems.manoeuvre import long_way_probability
from jaxatt.problems.time_optimal.paths import Paths, states_along
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats

_SPREAD = 0.1
_MOST_STRETCHES = 12
_FIRST_DURATION = 10.0


def random_paths(task: ReorientationTask, count: int, seed: int) -> Paths:
    """Draw starts of a task; start i depends on the seed and on i only.

    Where effort costs nothing the torques are spread a little as well: a path about the axis
    between the attitudes alone may be a saddle of the final time, and stay one.
    """
    n = task.intervals
    drawn = np.stack([np.random.default_rng((seed, i)).random(draws(task)) for i in range(count)])
    share = 1.0 - drawn[:, : n + 2]
    share[:, :2], share[:, n:] = 0.0, 1.0
    ways = _headings(task, count)
    away = drawn[:, n + 2] < np.array([_goes_the_long_way(way) for way in ways])
    sign = np.where(away, -1.0, 1.0)
    sigma = np.stack([way.turn(s) for way, s in zip(ways, sign, strict=True)])
    either = away[:, None] & (task.target.boresight is None)  # a free roll makes the ways one
    reference = np.where(either, task.reference(-1.0), task.reference(1.0))
    nodes = share[:, :, None] * sigma[:, None]
    step = np.full(count, _FIRST_DURATION / n)
    for _ in range(_MOST_STRETCHES):
        u, omega = _followed(task, nodes, step)
        most = np.maximum(np.abs(task.actuation.lower), task.actuation.upper)
        over = (np.abs(u) / most).max(axis=(1, 2))
        # From rest torques fall with the square of the time, and one stretch is enough.
        if (over <= 1.0 + 1e-12).all() and _ > 0:
            break
        step = step * np.where((over > 1.0) | (_ == 0), np.sqrt(np.maximum(over, 1e-12)), 1.0)
    goal = task.goal
    step = np.clip(step, goal.shortest / n, goal.longest / n)
    u, omega = _followed(task, nodes, step)
    if goal.effort_weight == 0.0:
        u = u + _SPREAD * (2.0 * drawn[:, n + 3 :].reshape(u.shape) - 1.0)
    u = np.clip(u, task.actuation.lower, task.actuation.upper)
    at = nodes[:, : n + 1]
    states = states_along(task, _attitudes(task, at), omega, _to_body(at, task.momentum), u, step)
    return Paths(u, states, step, reference, np.full(count, goal.effort_weight))


def _headings(task: ReorientationTask, count: int) -> list[ReorientationTask]:
    """The turn that each start makes: where the roll at the end is free, with its own."""
    if task.target.boresight is None:
        return [task] * count
    return [task.aiming_at(q) for q in task.target.of_starts(count).q_ob]


def _goes_the_long_way(task: ReorientationTask) -> float:
    """Probability with which a start of a turn goes the long way round."""
    turn = task.turn(1.0)
    vector = 4.0 * np.arctan(np.linalg.norm(turn)) * turn / max(1e-300, np.linalg.norm(turn))
    return long_way_probability(vector, np.asarray(task.initial_state.omega_ob), _FIRST_DURATION)


def draws(task: ReorientationTask) -> int:
    """Number of random values that a start needs."""
    return task.intervals + 3 + task.intervals * task.actuation.size


def _followed(task: ReorientationTask, nodes: Floats, step: Floats) -> tuple[Floats, Floats]:
    """Scaled controls (S, N, b) that follow relative MRP (S, N + 2, 3), and rates (S, N + 1, 3)."""
    count = task.intervals
    slope = np.diff(nodes, axis=1) / step[:, None, None]
    omega = _rates(nodes[:, : count + 1], slope)
    omega[:, 0] = task.initial_state.omega_ob
    omega[:, count] = task.target.of_starts(len(nodes)).omega_ob
    change = np.diff(omega, axis=1) / step[:, None, None]
    craft = task.craft
    inertia = np.asarray(craft.inertia)
    if task.form.body.momentum == "own":
        momentum = omega[:, :count] @ inertia
    else:
        momentum = _to_body(nodes[:, :count], task.momentum)
    needed = change @ np.asarray(craft.inertia_without_spin).T
    needed = needed + np.cross(omega[:, :count], momentum)
    a = task.actuation
    return np.asarray(needed @ np.linalg.pinv(a.to_external - a.to_body).T), np.asarray(omega)


def _attitudes(task: ReorientationTask, sigma: Floats) -> Floats:
    """Attitudes (..., 4) after turns by MRP (..., 3) from the start."""
    squared = (sigma**2).sum(axis=-1, keepdims=True)
    relative = np.concatenate([1.0 - squared, 2.0 * sigma], axis=-1) / (1.0 + squared)
    return np.asarray(quaternion.multiply(np.asarray(task.initial_state.q_ob), relative))


def _rates(sigma: Floats, slope: Floats) -> Floats:
    """Rates omega (..., 3) from MRP and their derivatives; eq. (5)."""
    squared = (sigma**2).sum(axis=-1, keepdims=True)
    along = (sigma * slope).sum(axis=-1, keepdims=True) * sigma
    turned = (1.0 - squared) * slope - 2.0 * np.cross(sigma, slope) + 2.0 * along
    return np.asarray(4.0 / (1.0 + squared) ** 2 * turned)


def _to_body(sigma: Floats, vector: Floats) -> Floats:
    """Turn a vector from the start's body axes to those after a turn by MRP, (..., 3)."""
    squared = (sigma**2).sum(axis=-1, keepdims=True)
    once = np.cross(sigma, vector)
    twice = np.cross(sigma, once)
    return np.asarray(vector + (8.0 * twice - 4.0 * (1.0 - squared) * once) / (1.0 + squared) ** 2)
