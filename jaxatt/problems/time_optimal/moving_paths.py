"""Starts of a reorientation of a body in motion, or with wheels that store momentum.

Random shares of the turn at every node (`random_paths`) suit a body at rest.  A spin would have to
stop within one interval of such a path, and stored momentum resists every turn that is taken back.
So a body in motion follows a smooth path, a product of three turns in its own axes:

    brake       about the axis of the initial rate, slowing down evenly within a random part of the
                time; the turns that this takes stay turned
    turn        what is left to the target, short or long, from rest to rest with random detours
    speed up    to the target's rate, as the brake in reverse

It takes as long as the torques that follow from inverse dynamics need to stay within their limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.problems.time_optimal.host_turns import conjugate, product, to_body, turn_of, turned_by
from jaxatt.problems.time_optimal.paths import Paths, states_along
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Flags, Floats

_LEAST_PART = 0.2
"""Of the time, in which a start may brake or speed up."""
_DETOUR = 0.7
"""[rad] Largest detour of the wildest start, in each axis."""
_SPREAD = 0.1
_LONG_WAY = 0.25
_TIMES = np.geomspace(0.05, 20.0, 60)
"""Times that are tried, in units of a crude one."""
_NEAR = 1e-4
"""Of the time, for rates by central differences."""


@dataclass(frozen=True, eq=False)
class _Shape:
    """Random choices of S starts.

    brake, speed_up : (S, 1) parts of the time.  away : (S, 1), whether what is left is turned the
    long way.  detours : (S, 2, 3) [rad].
    """

    brake: Floats
    speed_up: Floats
    away: Flags
    detours: Floats


def moving_paths(task: ReorientationTask, count: int, seed: int) -> Paths:
    """Draw starts of a task; start i depends on the seed and on i only."""
    n, goal = task.intervals, task.goal
    size = 9 + n * task.actuation.size
    drawn = np.stack([np.random.default_rng((seed, i)).random(size) for i in range(count)])
    part, even = _LEAST_PART, 2.0 * drawn - 1.0
    # The first start is the plain path; the others stray by as much as they draw.
    wild = np.where(np.arange(count) == 0, 0.0, drawn[:, 0])[:, None, None]
    shape = _Shape(
        part + (1.0 - part) * drawn[:, 1:2],
        part + (1.0 - part) * drawn[:, 2:3],
        drawn[:, :1] < np.where(np.arange(count) == 0, 0.0, _LONG_WAY)[:, None],
        _DETOUR * wild * even[:, 3:9].reshape(-1, 2, 3),
    )
    duration = np.clip(_long_enough(task, shape), goal.shortest, goal.longest)
    u, q, omega, momentum = _followed(task, shape, duration)
    if goal.effort_weight == 0.0:
        u = u + _SPREAD * even[:, 9:].reshape(u.shape)
    u = np.clip(u, task.actuation.lower, task.actuation.upper)
    short = np.sum(q[:, -1] * _target(task), axis=1, keepdims=True) >= 0.0
    reference = np.where(short, task.reference(1.0), task.reference(-1.0))
    step = duration / n
    attitude = product(np.asarray(task.initial_state.q_ob), q)
    states = states_along(task, attitude, omega, momentum, u, step)
    return Paths(u, states, step, reference, np.full(count, goal.effort_weight))


def _target(task: ReorientationTask) -> Floats:
    """Target relative to the start, the short way, (4,)."""
    q = product(conjugate(np.asarray(task.initial_state.q_ob)), np.asarray(task.target.q_ob))
    return q if q[0] >= 0.0 else -q


def _turned(task: ReorientationTask, shape: _Shape, duration: Floats, at: Floats) -> Floats:
    """Attitudes (S, M, 4) relative to the start, at parts (M,) of the durations (S,) [s]."""
    total, x = duration[:, None, None], at[None, :, None]
    brake, speed_up = shape.brake[..., None], shape.speed_up[..., None]

    def slowing(part: Floats, since: Floats) -> Floats:
        """Angle [s times the rate] turned while slowing down evenly within a part of the time."""
        share = np.minimum(since / part, 1.0)
        return part * total * (share - 0.5 * share**2)

    def braked(since: Floats) -> Floats:
        return turned_by(slowing(brake, since) * task.initial_state.omega_ob)

    def to_go(left: Floats) -> Floats:
        return turned_by(-slowing(speed_up, left) * task.target.omega_ob)

    begin, one = conjugate(to_go(np.ones((1, 1, 1)))), np.ones((1, 1, 1))
    rest = product(conjugate(begin), product(conjugate(braked(one)), _target(task)))
    rest = rest * np.where(rest[..., :1] >= 0.0, 1.0, -1.0)
    rest = rest * np.where(shape.away[..., None], -1.0, 1.0)
    arch = 16.0 * x**2 * (1.0 - x) ** 2
    detour = shape.detours[:, :1] * arch + shape.detours[:, 1:] * arch * (1.0 - 2.0 * x)
    turn = turned_by((3.0 * x**2 - 2.0 * x**3) * turn_of(rest) + detour)
    return product(product(braked(x), product(begin, turn)), to_go(1.0 - x))


def _followed(
    task: ReorientationTask, shape: _Shape, duration: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Scaled controls (S, N, b), and attitudes relative to the start, rates and total momentum.

    The last three at the nodes, (S, N + 1, ...), rates and momentum in body axes.
    """
    n, craft = task.intervals, task.craft
    at = np.arange(n + 1) / n
    q = _turned(task, shape, duration, at)
    ahead = _turned(task, shape, duration, np.minimum(at + _NEAR, 1.0))
    behind = _turned(task, shape, duration, np.maximum(at - _NEAR, 0.0))
    apart = np.minimum(at + _NEAR, 1.0) - np.maximum(at - _NEAR, 0.0)
    omega = turn_of(product(conjugate(behind), ahead)) / (
        apart[None, :, None] * duration[:, None, None]
    )
    omega[:, 0], omega[:, n] = task.initial_state.omega_ob, task.target.omega_ob
    if task.form.body.momentum == "own":
        momentum = omega @ np.asarray(craft.inertia)
    else:
        momentum = to_body(q, task.momentum)
    step = duration[:, None, None] / n
    needed = np.diff(omega, axis=1) / step @ np.asarray(craft.inertia_without_spin)
    turning = np.cross(omega, momentum)
    needed = needed + 0.5 * (turning[:, 1:] + turning[:, :-1])
    return needed @ _allocation(task).T, q, omega, momentum


def _allocation(task: ReorientationTask) -> Floats:
    """Scaled controls of a torque on the body, (b, 3) [1/(N m)]."""
    return np.asarray(np.linalg.pinv(task.actuation.to_external - task.actuation.to_body))


def _long_enough(task: ReorientationTask, shape: _Shape) -> Floats:
    """Shortest times (S,) [s] tried at which the torques stay within their limits.

    Where they never do, as where a fast spin meets much stored momentum, those at which they come
    nearest.
    """
    a, craft = task.actuation, task.craft
    most = np.maximum(np.abs(a.lower), a.upper)
    weakest = 1.0 / np.abs(_allocation(task) / most[:, None]).max()
    inertia = float(np.linalg.eigvalsh(np.asarray(craft.inertia)).max())
    spun = inertia * np.abs([task.initial_state.omega_ob, task.target.omega_ob]).max()
    carried = float(np.linalg.norm(task.momentum))
    crude = 2.0 * np.sqrt(np.pi * inertia / weakest) + (spun + np.pi * carried) / weakest
    chosen = np.full(len(shape.brake), crude)
    least = np.full(len(shape.brake), np.inf)
    for time in crude * _TIMES:
        u = _followed(task, shape, np.full(len(shape.brake), time))[0]
        over = np.maximum(1.0, (np.abs(u) / most).max(axis=(1, 2)))
        nearer = over < 0.999 * least
        chosen, least = np.where(nearer, time, chosen), np.where(nearer, over, least)
        if (least <= 1.0).all():
            break
    return chosen
