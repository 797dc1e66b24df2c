"""Smooth random paths between two attitudes and rates, and the torques that follow them.

A path is a product of three turns in the body's own axes:

    brake       about the axis of the initial rate, slowing down evenly within a random part of the
                time; the turns that this takes stay turned
    turn        what is left to the target, short or long, from rest to rest with random detours
    speed up    to the target's rate, as the brake in reverse

The torques follow from inverse dynamics, with the momentum that wheels store.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.attitude.host_turns import conjugate, product, to_body, turn_of, turned_by
from jaxatt.runtime.arrays import Flags, Floats

_DETOUR = 0.7
"""[rad] Largest detour of the wildest path, in each axis."""
_LONG_WAY = 0.25
_NEAR = 1e-4
"""Of the time, for rates by central differences."""

DRAWS = 9
"""Random values that a path needs."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Where paths begin and end, relative to the inertial frame.

    q : (4,) and end : (S, 1, 4), attitudes.  rate : (3,) and end_rate : (S, 1, 3) [rad/s], in body
    axes.
    momentum : (3,) [N m s], total at the start in body axes; None where it is all the body's own
    and thrusters change it.
    inertia, without_spin : (3, 3) [kg m^2], of the vehicle with wheels, and without their spin.
    """

    q: Floats
    rate: Floats
    end: Floats
    end_rate: Floats
    momentum: Floats | None
    inertia: Floats
    without_spin: Floats

    @property
    def relative(self) -> Floats:
        """End relative to the start, the short way, (S, 1, 4)."""
        q = product(conjugate(self.q), self.end)
        return np.where(q[..., :1] >= 0.0, q, -q)


@dataclass(frozen=True, eq=False)
class Shapes:
    """Random choices of S paths.

    brake, speed_up : (S, 1) parts of the time.  away : (S, 1), whether what is left is turned the
    long way.  detours : (S, 2, 3) [rad], in inertial axes: body axes may be named anew.
    """

    brake: Floats
    speed_up: Floats
    away: Flags
    detours: Floats


@dataclass(frozen=True, eq=False)
class Followed:
    """S paths at N + 1 nodes.

    torque : (S, N, 3) [N m], on the body in the middle of every interval.  q : (S, N + 1, 4),
    relative to the start.  omega : (S, N + 1, 3) [rad/s] and momentum : (S, N + 1, 3) [N m s],
    total, in body axes.
    """

    torque: Floats
    q: Floats
    omega: Floats
    momentum: Floats


def shapes(drawn: Floats, least_brake: float, least_speed_up: float) -> Shapes:
    """Shapes of random values (S, 9) in [0, 1]; the first one makes no detour.

    least_brake, least_speed_up : parts of the time in which a path may brake or speed up.
    """
    plain = np.arange(len(drawn)) == 0
    wild = np.where(plain, 0.0, drawn[:, 0])[:, None, None]
    part = np.array([least_brake, least_speed_up]) ** (1.0 - drawn[:, 1:3])
    away = drawn[:, :1] < np.where(plain, 0.0, _LONG_WAY)[:, None]
    detours = _DETOUR * wild * (2.0 * drawn[:, 3:9] - 1.0).reshape(-1, 2, 3)
    return Shapes(part[:, :1], part[:, 1:], away, detours)


def attitudes(ends: Ends, shape: Shapes, duration: Floats, at: Floats) -> Floats:
    """Attitudes (S, M, 4) relative to the start, at parts (M,) of the durations (S,) [s]."""
    total, x = duration[:, None, None], at[None, :, None]
    brake, speed_up = shape.brake[..., None], shape.speed_up[..., None]

    def slowing(part: Floats, since: Floats) -> Floats:
        """Angle [s times the rate] turned while slowing down evenly within a part of the time."""
        share = np.minimum(since / part, 1.0)
        return np.asarray(part * total * (share - 0.5 * share**2))

    def braked(since: Floats) -> Floats:
        return turned_by(slowing(brake, since) * ends.rate)

    def to_go(left: Floats) -> Floats:
        return turned_by(-slowing(speed_up, left) * ends.end_rate)

    begin, one = conjugate(to_go(np.ones((1, 1, 1)))), np.ones((1, 1, 1))
    rest = product(conjugate(begin), product(conjugate(braked(one)), ends.relative))
    rest = rest * np.where(rest[..., :1] >= 0.0, 1.0, -1.0)
    rest = rest * np.where(shape.away[..., None], -1.0, 1.0)
    arch = 16.0 * x**2 * (1.0 - x) ** 2
    detours = to_body(ends.q, shape.detours)
    detour = detours[:, :1] * arch + detours[:, 1:] * arch * (1.0 - 2.0 * x)
    turn = turned_by((3.0 * x**2 - 2.0 * x**3) * turn_of(rest) + detour)
    return product(product(braked(x), product(begin, turn)), to_go(1.0 - x))


def follow(ends: Ends, shape: Shapes, duration: Floats, intervals: int) -> Followed:
    """Torques and states along paths of durations (S,) [s]."""
    at = np.arange(intervals + 1) / intervals
    before, after = np.maximum(at - _NEAR, 0.0), np.minimum(at + _NEAR, 1.0)
    q = attitudes(ends, shape, duration, at)
    behind, ahead = (attitudes(ends, shape, duration, x) for x in (before, after))
    apart = (after - before)[None, :, None] * duration[:, None, None]
    omega = turn_of(product(conjugate(behind), ahead)) / apart
    omega[:, 0], omega[:, -1] = ends.rate, ends.end_rate[:, 0]
    momentum = omega @ ends.inertia if ends.momentum is None else to_body(q, ends.momentum)
    change = np.diff(omega, axis=1) * (intervals / duration)[:, None, None]
    turning = np.cross(omega, momentum)
    torque = change @ ends.without_spin + 0.5 * (turning[:, 1:] + turning[:, :-1])
    return Followed(torque, q, omega, momentum)
