"""Starting points; start i depends on the seed and on i, never on how many there are."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.problems.task import Floats

_AMPLITUDE = 0.01
_SPREAD = 1.5
_RELATIVE_NOISE = 0.3


class Starts(NamedTuple):
    """S starts.

    u : (S, N, b), scaled controls.  sign : (S,), -1 to aim the long way round.
    confined : (S,), whether to look inside the cheap windows only at first.
    """

    u: Floats
    sign: Floats
    confined: np.ndarray


def _draw(key: Array, index: Array, intervals: int, size: int) -> tuple[Array, Array, Array]:
    pulses, heights, coins = jax.random.split(jax.random.fold_in(key, index), 3)
    height = jnp.exp(_SPREAD * jax.random.normal(heights, (intervals, 1)))
    direction = jax.random.normal(pulses, (intervals, size))
    return direction, height, jax.random.uniform(coins, (2,))


def draw(
    seed: int,
    count: int,
    intervals: int,
    size: int,
    long_way_probability: float,
    guess: Floats | None = None,
) -> Starts:
    """Random pulses of log-normal height, or a guess with random relative changes.

    guess : (N, b) scaled controls, e.g. of a PD or L1 solution or the user's own; start 0 is the
    guess itself.
    """
    key = jax.random.key(seed)
    direction, height, coins = jax.jit(
        jax.vmap(lambda i: _draw(key, i, intervals, size))
    )(jnp.arange(count))
    if guess is None:
        u = _AMPLITUDE * np.asarray(direction * height)
    else:
        change = np.where(np.arange(count)[:, None, None] == 0, 0.0, np.asarray(direction))
        u = guess[None] * (1.0 + _RELATIVE_NOISE * change)
    coins = np.asarray(coins)
    sign = np.where(coins[:, 0] < long_way_probability, -1.0, 1.0)
    return Starts(np.asarray(u), sign, coins[:, 1] < 0.5)
