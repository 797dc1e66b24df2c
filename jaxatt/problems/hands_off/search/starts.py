"""Random starting points; start i depends on the seed and on i only."""

from __future__ import annotations

from statistics import NormalDist
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.compilation import Routine
from jaxatt.runtime.lengths import rounded_up

_AMPLITUDE = 0.003
_SPREAD = 1.5
_RELATIVE_NOISE = 0.3
_SHARED = 256
"""Numbers drawn for a start are multiples of this, so that programs are shared."""


class Starts(NamedTuple):
    """Starting points; leading axis S.

    u : (S, N, b), scaled controls.  sign : (S,), -1 to aim the long way round.
    confined : (S,), whether to look inside the cheap windows only at first.
    """

    u: Floats
    sign: Floats
    confined: np.ndarray


def _draw_normals(count: int, length: int, seed: int) -> Array:
    """Standard normals (count, length); row i depends on the seed and i alone."""
    key = jax.random.key(seed)
    return jax.vmap(lambda i: jax.random.normal(jax.random.fold_in(key, i), (length,)))(
        jnp.arange(count)
    )


_normals = Routine(_draw_normals, statics=2)


def draw(
    seed: int,
    count: int,
    intervals: int,
    size: int,
    long_way_probability: float,
    guess: Floats | None = None,
) -> Starts:
    """Draw random pulses of log-normal height, or random changes of a guess.

    guess : (N, b) scaled controls, e.g. of a PD or L1 solution or the user's own; start 0 is the
    guess itself.
    """
    per_start = intervals * (size + 1) + 2
    # Longer rows begin alike, so that other numbers of intervals share the program.
    normals = np.asarray(_normals(count, rounded_up(per_start, _SHARED), seed))
    pulses = normals[:, 2:per_start].reshape(count, intervals, size + 1)
    direction, height = pulses[..., :size], np.exp(_SPREAD * pulses[..., size:])
    if guess is None:
        u = _AMPLITUDE * direction * height
    else:
        change = np.where(np.arange(count)[:, None, None] == 0, 0.0, direction)
        u = guess[None] * (1.0 + _RELATIVE_NOISE * change)
    sign = np.where(normals[:, 0] < _quantile(long_way_probability), -1.0, 1.0)
    return Starts(u, sign, normals[:, 1] < 0.0)


def _quantile(probability: float) -> float:
    """Quantile of the standard normal distribution."""
    if not 0.0 < probability < 1.0:
        return np.inf if probability >= 1.0 else -np.inf
    return NormalDist().inv_cdf(probability)
