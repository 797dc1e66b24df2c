"""Starts of IPOPT for bodies in motion that know what a manoeuvre looks like.

By turns the straight turn, a flight of a PD law, the body left to itself, and a flight under random
torques; the first of each as it is, later ones with more and more noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.inertial_manoeuvre import InertialManoeuvre
from jaxatt.attitude import host_turns
from jaxatt.runtime.arrays import Floats

_SUBSTEPS = 6
_NOISE = 0.3
_DAMPING = 2.0

Control = Callable[[int, Floats, Floats], Floats]
"""(interval, attitude (4,), rate (3,) [rad/s]) -> controls (b,)."""


@dataclass(frozen=True, eq=False)
class Start:
    """u : (N, b), controls.  states : (N + 1, 7), q_ib and omega_ib [rad/s].  step : [s]."""

    u: Floats
    states: Floats
    step: float


def informed_starts(
    m: InertialManoeuvre, intervals: int, duration: float | None, count: int, seed: int
) -> list[Start]:
    """Draw starts; start i depends on the seed and on i alone.

    duration : [s]; None where it is free, for a time that a turn by the weakest torque takes, and
    up to twice as much.
    """
    found = []
    for index in range(count):
        rng = np.random.default_rng((seed, index))
        noise = _NOISE * (index // 4) * rng.uniform()
        longer = 1.0 if index < 4 else rng.uniform(1.0, 2.0)
        total = _crude_time(m) * longer if duration is None else duration
        kind = (_straight, _controlled, _coasting, _random)[index % 4]
        found.append(kind(m, intervals, total / intervals, noise, rng))
    return found


def _crude_time(m: InertialManoeuvre) -> float:
    angle = np.linalg.norm(host_turns.turn_of(_to_go(m.start, m.target)))
    change = np.linalg.norm(m.start_rate) + np.linalg.norm(m.target_rate)
    return float(2.0 * np.sqrt(angle / m.weakest) + change / m.weakest)


def _to_go(q: Floats, target: Floats) -> Floats:
    """Turn that is left, the short way, (4,)."""
    relative = host_turns.product(host_turns.conjugate(q), target)
    return relative if relative[0] >= 0.0 else -relative


def _flown(m: InertialManoeuvre, steps: int, h: float, control: Control) -> Start:
    """Flight under controls held for h [s] each."""
    x, held = np.concatenate([m.start, m.start_rate])[None], []
    states = [x[0]]
    for k in range(steps):
        held.append(_within(m, control(k, x[0, :4], x[0, 4:])))
        x = m.after(x, held[-1][None], np.array([[h]]), _SUBSTEPS)
        states.append(x[0])
    return Start(np.array(held), np.array(states), h)


def _within(m: InertialManoeuvre, u: Floats) -> Floats:
    """Controls (..., b) scaled down to their limits."""
    relative = np.concatenate([u, u @ m.others.T], axis=-1)
    return np.asarray(u / np.maximum(1.0, np.abs(relative).max(axis=-1, keepdims=True)))


def _straight(
    m: InertialManoeuvre, n: int, h: float, noise: float, rng: np.random.Generator
) -> Start:
    """Turn about one axis with a smooth rate, every other time the long way round."""
    relative = _to_go(m.start, m.target) * (1.0 if noise == 0.0 or rng.uniform() < 0.5 else -1.0)
    turn, x = host_turns.turn_of(relative), np.arange(n + 1)[:, None] / n
    bent = noise * rng.normal(size=3) * np.sin(np.pi * x) ** 2
    q = host_turns.product(m.start, host_turns.turned_by((3.0 * x**2 - 2.0 * x**3) * turn + bent))
    rate = (6.0 * x - 6.0 * x**2) * turn / (n * h)
    blend = np.clip(4.0 * x, 0.0, 1.0), np.clip(4.0 * (1.0 - x), 0.0, 1.0)
    rate = rate + (1.0 - blend[0]) * m.start_rate + (1.0 - blend[1]) * m.target_rate
    middle = 0.5 * (rate[1:] + rate[:-1])
    needed = np.diff(rate, axis=0) / h - m.acceleration(
        0.5 * (q[1:] + q[:-1]), middle, np.zeros((n, m.to_body.shape[1]))
    )
    u = -needed @ np.linalg.pinv(m.inverse_inertia @ m.to_body).T
    return Start(_within(m, u), np.concatenate([q, rate], axis=1), h)


def _controlled(
    m: InertialManoeuvre, n: int, h: float, noise: float, rng: np.random.Generator
) -> Start:
    """Flight of a PD law that compensates the momentum, as fast as the time asks for."""
    natural = 8.0 / (n * h) * (1.0 + noise * rng.uniform(-0.5, 1.0))
    torques = np.linalg.pinv(m.inverse_inertia @ m.to_body)

    def law(_: int, q: Floats, rate: Floats) -> Floats:
        error = host_turns.turn_of(_to_go(q, m.target))
        wanted = natural**2 * error - _DAMPING * natural * (rate - m.target_rate)
        free = m.acceleration(q[None], rate[None], np.zeros((1, m.to_body.shape[1])))[0]
        return np.asarray(torques @ (free - wanted))

    return _flown(m, n, h, law)


def _coasting(
    m: InertialManoeuvre, n: int, h: float, noise: float, rng: np.random.Generator
) -> Start:
    """The body left to itself, or nearly."""
    u = 0.1 * noise * rng.normal(size=(n, m.to_body.shape[1]))
    return _flown(m, n, h, lambda k, *_: u[k])


def _random(
    m: InertialManoeuvre, n: int, h: float, noise: float, rng: np.random.Generator
) -> Start:
    """Flight under random torques."""
    u = (0.3 + noise) * rng.normal(size=(n, m.to_body.shape[1]))
    return _flown(m, n, h, lambda k, *_: u[k])
