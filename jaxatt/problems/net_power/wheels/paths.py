"""Attitudes to fly through: to the sun, hold, and on to the end; or straight there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.problems.net_power.wheels.host import conjugate, exponential, logarithm, product
from jaxatt.problems.net_power.wheels.task import WheelsTask
from jaxatt.runtime.arrays import Floats

_SMOOTH = 2.0 * np.pi
"""Peak of the second derivative of the smooth profile between 0 and 1 in unit time."""
_MARGIN = 0.85
"""Share of the wheels' torque that a path takes."""
_STRAIGHT = 0.1
"""Share of the starts that turn straight to the end."""


@dataclass(frozen=True, eq=False)
class Way:
    """Where starts turn to, and when; leading axis S.

    middle : (S, 4), attitude to hold.  first, second : (S,) [s], lengths of the two turns.
    """

    middle: Floats
    first: Floats
    second: Floats


def ways(task: WheelsTask, count: int, seed: int) -> Way:
    """Draw ways of a task; start i depends on the seed and on i only.

    The sun attitudes are those of its best directions, with any roll about the line to the sun.
    Where there is no time for the whole way, the attitude is moved towards the direct turn.
    """
    drawn = np.stack([np.random.default_rng((seed, i)).random(8) for i in range(count)])
    # Rolls spread evenly, rather than by chance alone: neighbours in number differ most.
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    roll = 2.0 * np.pi * (drawn[0, 0] + golden * np.arange(count)) % (2.0 * np.pi)
    which = (drawn[:, 1] * len(task.best.body)).astype(int)
    sun = np.asarray(task.parameters.stages.sun)
    shone = np.asarray(task.parameters.stages.shone)
    facing = np.average(sun, axis=0, weights=np.maximum(shone, 1e-12 * (1.0 + shone.max())))
    facing = facing / np.linalg.norm(facing)
    middle = _towards(task.best.body[which], facing, roll)
    begin, end = _ends(task)
    total = task.manoeuvre.duration
    slow = 1.0 + 0.5 * drawn[:, 2:4] ** 2
    direct = product(begin, exponential(0.5 * logarithm(product(conjugate(begin), end))))
    direct = np.broadcast_to(direct, middle.shape)
    share = np.where(drawn[:, 4] < _STRAIGHT, 0.0, 1.0)
    aside = logarithm(product(conjugate(direct), middle))
    for _ in range(12):
        placed = product(direct, exponential(share[:, None] * aside))
        first = slow[:, 0] * turn_time(task, begin, placed)
        second = slow[:, 1] * turn_time(task, placed, end)
        long = first + second > total
        share = np.where(long, 0.8 * share, share)
    fit = np.minimum(1.0, total / (first + second))
    return Way(placed, first * fit, second * fit)


def _ends(task: WheelsTask) -> tuple[Floats, Floats]:
    begin = np.asarray(task.parameters.start[:4])
    end = begin if task.manoeuvre.end is None else np.asarray(task.parameters.reference)
    return begin, end


def _towards(body: Floats, inertial: Floats, roll: Floats) -> Floats:
    """Attitudes (S, 4) that bring body directions (S, 3) onto an inertial one, with any roll."""
    axis = np.cross(body, inertial)
    cosine = body @ inertial
    other = np.cross(body, np.eye(3)[np.abs(body).argmin(axis=1)])
    other = other / np.linalg.norm(other, axis=1, keepdims=True)
    opposite = (cosine < -1.0 + 1e-9)[:, None]
    bare = np.concatenate([1.0 + cosine[:, None], axis], axis=1)
    bare = np.where(opposite, np.concatenate([0.0 * cosine[:, None], other], axis=1), bare)
    bare = bare / np.linalg.norm(bare, axis=1, keepdims=True)
    return product(exponential(roll[:, None] * inertial), bare)


def turn_time(task: WheelsTask, begin: Floats, end: Floats) -> Floats:
    """Time (S,) [s] of turns from rest to rest about one axis, within the torque limits."""
    vector = logarithm(product(conjugate(begin), end))
    torque = np.abs(vector @ np.asarray(task.parameters.without_spin).T @ _spread(task).T)
    share = (torque / (_MARGIN * np.asarray(task.parameters.torque_limit))).max(axis=1)
    time: Floats = np.sqrt(_SMOOTH * np.maximum(share, 1e-9))
    return time


def _spread(task: WheelsTask) -> Floats:
    """Torques of the wheels from one in body axes, (n, 3)."""
    axes = np.asarray(task.parameters.axes)
    spread: Floats = axes.T @ np.asarray(task.parameters.spread)
    return spread


def _profile(s: Floats) -> Floats:
    s = np.clip(s, 0.0, 1.0)
    smooth: Floats = s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi)
    return smooth


def references(task: WheelsTask, way: Way, times: Floats) -> Floats:
    """Attitudes (S, n, 4) along the ways, at times (n,) [s] after their beginning."""
    begin, end = _ends(task)
    total = task.manoeuvre.duration
    first = _profile(times[None] / way.first[:, None])
    back = logarithm(product(conjugate(way.middle), begin))
    path = product(way.middle[:, None], exponential((1.0 - first)[..., None] * back[:, None]))
    if task.manoeuvre.end is None:
        return path
    rate = np.asarray(task.parameters.reference_rate)
    leave = total - way.second
    final = product(end, exponential((times - total)[:, None] * rate))
    leaving = product(end, exponential((leave - total)[:, None] * rate))
    apart = logarithm(product(conjugate(leaving), way.middle))
    second = _profile((times[None] - leave[:, None]) / way.second[:, None])
    closing = product(final[None], exponential((1.0 - second)[..., None] * apart[:, None]))
    after = (times[None] >= leave[:, None])[..., None]
    return np.where(after, closing, path)
