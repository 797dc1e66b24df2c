"""Informed first guesses: two random pulses with the turn between them.

They know what the answer looks like: two active intervals, an eigenaxis turn at a constant rate
between them, and pulses that the wheels can deliver.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.casadi_model import RATE_UNIT, Floats, SlewNumbers, multiply, rotation

_RESERVE = 1.2
"""How much below the wheels' limits the guessed pulses are; the turn is no eigenaxis turn."""


@dataclass(frozen=True, eq=False)
class Guess:
    """controls : (N, 3), as in `SlewNumbers`.  xi : (N,).  states : (N, 7) at nodes 1 to N."""

    controls: Floats
    xi: Floats
    states: Floats


def conjugate(q: Floats) -> Floats:
    """Inverse of a unit quaternion (4,)."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def partial_turn(turn: Floats, share: Floats) -> Floats:
    """Quaternions (n, 4) of shares (n,) of a rotation vector (3,) [rad]."""
    angle = float(np.linalg.norm(turn))
    half = share[:, None] * angle / 2.0
    return np.concatenate([np.cos(half), np.sin(half) * turn / angle], axis=1)


def pulse_guess(numbers: SlewNumbers, seed: int, index: int) -> Guess:
    """Guess of start `index`; it depends on the seed and the index alone.

    Pairs of intervals too close to each other for the torque limits are drawn again.
    """
    draw = np.random.default_rng([seed, index])
    n, step = numbers.intervals, numbers.step
    error = multiply(
        conjugate(numbers.start), multiply(conjugate(numbers.orbit[-1]), numbers.target)
    )
    error = error if error[0] >= 0.0 else -error
    size = np.linalg.norm(error[1:])
    turn = 2.0 * np.arctan2(size, error[0]) * error[1:] / size
    # First pulse for a turn in one second; a torque on the wheels turns the body the other way.
    torque = -np.linalg.solve(numbers.inverse_inertia, turn) / step
    pulse = np.linalg.solve(numbers.to_body, torque)
    largest = np.abs(np.concatenate([pulse, numbers.other_wheels @ pulse])).max()
    least_gap = _RESERVE * largest / step
    if least_gap >= n:
        raise ValueError("two pulses cannot make this turn within the torque limits")
    while True:
        first, last = np.sort(draw.choice(n, 2, replace=False))
        if last - first >= least_gap:
            break
    duration = (last - first) * step

    controls, xi, states = np.zeros((n, 3)), np.ones(n), np.zeros((n, 7))
    controls[first], controls[last] = pulse / duration, -pulse / duration
    xi[[first, last]] = 0.0
    nodes = np.arange(1, n + 1)
    share = np.clip((nodes - first - 0.5) / (last - first), 0.0, 1.0)
    turning = (first < nodes) & (nodes <= last)
    q_ob = multiply(numbers.start, partial_turn(turn, share).T)
    # The orbit frame turns about one axis at almost one rate, seen here from the body.
    orbit_rate = 2.0 * multiply(conjugate(numbers.orbit[0]), numbers.orbit[1])[1:] / step
    carried = np.einsum("jin,j->ni", rotation(q_ob), orbit_rate)
    states[:, :4] = multiply(numbers.orbit[1:].T, q_ob).T
    states[:, 4:] = (turning[:, None] * turn / duration + carried) / RATE_UNIT
    return Guess(controls, xi, states)
