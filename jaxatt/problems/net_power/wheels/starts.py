"""Starts of a manoeuvre: ways to the sun and back, flown by feedback within the torque limits.

A start is what the satellite does when it follows such a way, so that its states obey the dynamics
(external torques aside) and its torques their limits, whatever rate it begins with.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from jaxatt.attitude.host_vectors import cross
from jaxatt.problems.net_power.wheels.host import (
    conjugate,
    exponential,
    logarithm,
    product,
    rotated,
)
from jaxatt.problems.net_power.wheels.paths import references, ways
from jaxatt.problems.net_power.wheels.task import WheelsTask
from jaxatt.problems.net_power.wheels.turn import turned
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.wheel_motor import friction

_BANDWIDTH = 0.4
"""Of the feedback, times the length of an interval; at most `_FASTEST`."""
_FASTEST = 0.8
_DAMPING = 0.9
_WITHIN = 0.95
_ROOM = 0.02
"""By which magnitudes of power begin above what they have to be at least."""


class Starts(NamedTuple):
    """Starts of one or more manoeuvres; leading axis S.

    u : (S, N, b), controls and x : (S, N + 1, s), states of the programme.
    reference : (S, 4), attitude to end in, with the sign of the way that the start goes.
    task : (S,), number of the manoeuvre that it is a start of.
    """

    u: Floats
    x: Floats
    reference: Floats
    task: Floats


def draw_starts(task: WheelsTask, count: int, seed: int) -> Starts:
    """Draw starts of a task; start i depends on the seed and on i only."""
    return draw_all([task], count, seed)[0]


def draw_all(tasks: Sequence[WheelsTask], count: int, seed: int) -> tuple[Starts, ...]:
    """Draw `count` starts for each of some tasks of one satellite, form and number of intervals.

    All are flown side by side: the flight takes as many calls of NumPy for a year's dates as for
    one start.
    """
    nodes = np.arange(tasks[0].manoeuvre.intervals + 2)
    ahead = [task.manoeuvre.step * nodes for task in tasks]
    along = [references(t, ways(t, count, seed), at) for t, at in zip(tasks, ahead, strict=True)]
    return follow_all(tasks, np.stack(along))


def follow(task: WheelsTask, attitudes: Floats) -> Starts:
    """Fly along attitudes (S, N + 2, 4) by feedback, from where the manoeuvre begins."""
    return follow_all([task], attitudes[None])[0]


def follow_all(tasks: Sequence[WheelsTask], attitudes: Floats) -> tuple[Starts, ...]:
    """Fly along attitudes (T, S, N + 2, 4) by feedback, from where each of T tasks begins."""
    p, form = tasks[0].parameters, tasks[0].form
    count = attitudes.shape[1]
    of: Any = np.repeat(np.arange(len(tasks)), count)
    attitudes = attitudes.reshape(-1, *attitudes.shape[2:])
    intervals = attitudes.shape[1] - 2
    h = np.array([task.manoeuvre.step for task in tasks])[of][:, None]
    begun = np.stack([np.asarray(task.parameters.start) for task in tasks])[of]
    total = np.stack([np.asarray(task.parameters.total) for task in tasks])[of]
    without, inverse = np.asarray(p.without_spin), np.asarray(p.inverse)
    axes, limit = np.asarray(p.axes), np.asarray(p.torque_limit)
    spread = (axes.T @ np.asarray(p.spread)) / limit[:, None]
    to_stored = np.asarray(p.to_stored)
    to_rate = np.asarray(p.to_rate)
    rates = logarithm(product(conjugate(attitudes[:, :-1]), attitudes[:, 1:])) / h[..., None]
    bandwidth = np.minimum(_FASTEST, _BANDWIDTH / h)
    q, y = begun[:, :4], begun[:, 4 : 4 + form.stored]
    states, controls = [], []
    for k in range(intervals):
        momentum = rotated(conjugate(q), total)
        lost = y @ to_rate.T
        omega = momentum @ inverse.T - lost
        # Where the way will be in the middle of the interval, with half of the rate's change.
        missed = logarithm(product(conjugate(attitudes[:, k]), q))
        wanted = 0.5 * (rates[:, max(k - 1, 0)] + rates[:, k])
        ahead = (rates[:, min(k + 1, intervals)] - rates[:, max(k - 1, 0)]) / (2.0 * h)
        change = ahead - 2.0 * _DAMPING * bandwidth * (omega - wanted) - bandwidth**2 * missed
        turning = cross(momentum, omega)
        scaled = np.clip((turning - change @ without.T) @ spread.T, -_WITHIN, _WITHIN)
        states.append((q, y))
        controls.append(scaled)
        slope = scaled @ to_stored.T @ to_rate.T
        speeding = turning @ inverse.T - slope
        bend = (cross(turning, omega) + cross(momentum, speeding)) @ inverse.T
        turn: Any = turned(tuple(omega.T), tuple(speeding.T), tuple(bend.T), h[:, 0])
        q, y = product(q, exponential(np.stack(turn, -1))), y + h * scaled @ to_stored.T
    states.append((q, y))
    parts = [np.stack([s[i] for s in states], axis=1) for i in range(2)]
    if form.torqued:
        parts.append(_kept(begun[:, 4 + form.stored :][:, :3], intervals))
    x = np.concatenate(parts, axis=2)
    scaled = np.stack(controls, axis=1)
    if form.charge:
        x = np.concatenate([x, _kept(begun[:, -1:], intervals)], axis=2)
    scale = np.array([float(task.parameters.power_scale) for task in tasks])[of]
    u = with_powers(tasks[0], total, scale, x, scaled)
    u = filled(u, len(np.asarray(p.stages.step)) - intervals)
    x = filled(x, u.shape[1] + 1 - x.shape[1], still=True)
    reference = np.stack([np.asarray(task.parameters.reference) for task in tasks])[of]
    whole = Starts(u, x, towards(reference, q), np.zeros(len(of), int))
    return tuple(
        Starts(*(leaf[k * count : (k + 1) * count] for leaf in whole)) for k in range(len(tasks))
    )


def towards(reference: Floats, q: Floats) -> Floats:
    """Attitudes (S, 4) with the sign that is nearer to where starts end, q (S, 4)."""
    sign = np.where(np.sum(q * reference, axis=1) < 0.0, -1.0, 1.0)
    return sign[:, None] * reference


def _kept(first: Floats, intervals: int) -> Floats:
    """States (S, N + 1, c) that stay as they begin, (S, c)."""
    return np.repeat(first[:, None], intervals + 1, axis=1)


def filled(along: Floats, more: int, still: bool = False) -> Floats:
    """Add `more` rows to (S, n, c): zeros, or copies of the last one."""
    last = along[:, -1:] if still else np.zeros_like(along[:, -1:])
    return np.concatenate([along, np.repeat(last, more, axis=1)], axis=1)


def with_powers(
    task: WheelsTask,
    total: Floats,
    scale: Floats,
    x: Floats,
    scaled: Floats,
    dipoles: Floats | None = None,
    room: float = _ROOM,
) -> Floats:
    """Controls of the programme: torques, magnitudes of their power, and dipoles where it has them.

    total : (S, 3), momenta where they are not carried.  scale : (S,), of powers.
    dipoles : (S, N, 6), a little by default.  room : of magnitudes over the least ones.
    """
    p, form = task.parameters, task.form
    parts = [scaled]
    if form.powers:
        speeds = _speeds(task, total, x)
        ends = [_powers(task, scaled, spins) for spins in (speeds[:, :-1], speeds[:, 1:])]
        power = np.concatenate(ends, axis=-1) / scale[:, None, None]
        parts.append(np.maximum(float(p.taken) * power, -float(p.returned) * power) + room)
    if form.dipoles:
        little = np.full((*scaled.shape[:2], form.dipoles), _ROOM)
        parts.append(little if dipoles is None else dipoles)
    return np.concatenate(parts, axis=-1)


def _powers(task: WheelsTask, scaled: Floats, speeds: Floats) -> Floats:
    """Power (..., c) [W] of the wheels; see `coordinates.wheel_power`."""
    p, form = task.parameters, task.form
    if form.rubbing:
        scaled = scaled + np.asarray(friction(p.motors, speeds))
    torque = scaled * np.asarray(p.torque_limit)
    if form.power == "wheels":
        each: Floats = torque * speeds
        return each
    axes = np.asarray(p.axes).T
    turning = speeds @ axes if form.each else speeds
    total: Floats = (torque @ axes * turning).sum(-1, keepdims=True)
    return total


def _speeds(task: WheelsTask, total: Floats, x: Floats) -> Floats:
    """Wheel speeds at all nodes, of every wheel or their sum; see `coordinates.wheel_speeds`."""
    p, form = task.parameters, task.form
    y = x[..., 4 : 4 + form.stored]
    held = total[:, None]
    if form.torqued:
        held = float(p.momentum_scale) * x[..., 4 + form.stored : 7 + form.stored]
    momentum = rotated(conjugate(x[..., :4]), held)
    omega = momentum @ np.asarray(p.inverse).T - y @ np.asarray(p.to_rate).T
    axes, inertia = np.asarray(p.axes), np.asarray(p.wheel_inertia)
    if not form.each:
        summed: Floats = y @ np.asarray(p.without_spin).T / inertia[0] - omega @ (axes @ axes.T)
        return summed
    own: Floats = float(p.momentum_scale) * y / inertia - omega @ axes
    return own
