"""Attitudes to fly through: to the sun, hold, and on to the end; or straight there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt.problems.net_power.wheels.host import conjugate, exponential, logarithm, product
from jaxatt.problems.net_power.wheels.task import WheelsTask
from jaxatt.runtime.arrays import Floats

_SMOOTH = 2.0 * np.pi
"""Peak of the second derivative of the smooth profile between 0 and 1 in unit time."""
_MARGIN = 0.85
"""Share of the wheels' torque that a path takes."""
_STRAIGHT = 0.08
"""Share of the starts that turn straight to the end."""
_CHOICE = 8
"""Sun attitudes that are drawn for every start, and share of the starts that take the quickest."""
_QUICKEST = 0.75
_MOST_SHORTENINGS, _SHORTER = 12, 0.8


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
    The first start, and most others, take the quickest of a few; where there is no time even for
    that, the attitude is moved towards the direct turn.
    """
    drawn = np.stack(
        [np.random.default_rng((seed, i)).random(4 + 2 * _CHOICE) for i in range(count)]
    )
    # The first start does what the PD law does, so that even one alone is worth something.
    drawn[0, :4] = 0.0, 0.0, 0.0, 1.0
    begin, end, _ = _ends(task, count)
    shape = (count * _CHOICE,)
    which = (drawn[:, 4 : 4 + _CHOICE].reshape(shape) * len(task.best.body)).astype(int)
    roll = 2.0 * np.pi * drawn[:, 4 + _CHOICE :].reshape(shape)
    offered = _towards(task.best.body[which], _sunward(task), roll)
    needed = turn_time(task, begin, offered)
    needed = needed + turn_time(task, offered, np.repeat(end, _CHOICE, axis=0))
    needed = needed.reshape(count, _CHOICE)
    chosen = np.where(drawn[:, 0] < _QUICKEST, needed.argmin(axis=1), 0)
    middle = offered.reshape(count, _CHOICE, 4)[np.arange(count), chosen]
    total = task.manoeuvre.duration
    slow = 1.0 + 0.3 * drawn[:, 1:3] ** 2
    direct = product(begin, exponential(0.5 * logarithm(product(conjugate(begin), end))))
    direct = np.broadcast_to(direct, middle.shape)
    share = np.where(drawn[:, 3] < _STRAIGHT, 0.0, 1.0)
    aside = logarithm(product(conjugate(direct), middle))
    for _ in range(_MOST_SHORTENINGS):
        placed = product(direct, exponential(share[:, None] * aside))
        first = slow[:, 0] * turn_time(task, begin, placed)
        second = slow[:, 1] * turn_time(task, placed, end)
        share = np.where(first + second > total, _SHORTER * share, share)
    fit = np.minimum(1.0, total / (first + second))
    return Way(placed, first * fit, second * fit)


def _sunward(task: WheelsTask) -> Floats:
    """Mean direction to the sun in inertial axes while it shines, (3,)."""
    sun, shone = np.asarray(task.parameters.stages.sun), np.asarray(task.parameters.stages.shone)
    facing = np.average(sun, axis=0, weights=shone + 1e-9)
    direction: Floats = facing / np.linalg.norm(facing)
    return direction


def _ends(task: WheelsTask, count: int) -> tuple[Floats, Floats, Floats]:
    """Where starts begin, (4,), and end, (S, 4), and their rates (S, 3) [rad/s] there."""
    begin = np.asarray(task.parameters.start[:4])
    if task.manoeuvre.end is None:
        return begin, np.tile(begin, (count, 1)), np.zeros((count, 3))
    end = task.manoeuvre.end.of_starts(count)
    return begin, end.q_ib / np.linalg.norm(end.q_ib, axis=1, keepdims=True), end.omega_ib


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
    """Time (S,) [s] of smooth turns from rest to rest about one axis, within the torque limits."""
    time: Floats = np.sqrt(_SMOOTH / _MARGIN * np.maximum(_squared_time(task, begin, end), 1e-9))
    return time


def quickest_turn(task: WheelsTask) -> float:
    """Time [s] of the quickest turn about one axis from the start to the end, from rest to rest."""
    begin, end, _ = _ends(task, 1)
    # Full torque one way and then the other.
    return float(2.0 * np.sqrt(_squared_time(task, begin, end)[0]))


def _squared_time(task: WheelsTask, begin: Floats, end: Floats) -> Floats:
    """Angle over the largest acceleration about the axis of each turn, (S,) [s^2]."""
    vector = logarithm(product(conjugate(begin), end))
    torque = np.abs(vector @ np.asarray(task.parameters.without_spin).T @ _spread(task).T)
    share: Floats = (torque / np.asarray(task.parameters.torque_limit)).max(axis=1)
    return share


def _spread(task: WheelsTask) -> Floats:
    """Torques of the wheels from one in body axes, (n, 3)."""
    axes = np.asarray(task.parameters.axes)
    spread: Floats = axes.T @ np.asarray(task.parameters.spread)
    return spread


def _profile(s: Floats) -> Floats:
    s = np.clip(s, 0.0, 1.0)
    smooth: Floats = s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi)
    return smooth


def references(task: WheelsTask, way: Way, times: Any) -> Floats:
    """Attitudes (S, n, 4) along the ways, at times (n,) [s] after their beginning."""
    begin, end, rate = _ends(task, len(way.middle))
    total = task.manoeuvre.duration
    first = _profile(times[None] / way.first[:, None])
    back = logarithm(product(conjugate(way.middle), begin))
    path = product(way.middle[:, None], exponential((1.0 - first)[..., None] * back[:, None]))
    if task.manoeuvre.end is None:
        return path
    leave = total - way.second
    final = product(end[:, None], exponential((times - total)[:, None] * rate[:, None]))
    leaving = product(end, exponential((leave - total)[:, None] * rate))
    apart = logarithm(product(conjugate(leaving), way.middle))
    second = _profile((times[None] - leave[:, None]) / way.second[:, None])
    closing = product(final, exponential((1.0 - second)[..., None] * apart[:, None]))
    after = (times[None] >= leave[:, None])[..., None]
    return np.where(after, closing, path)
