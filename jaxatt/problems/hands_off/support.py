"""The free controls of a sparse answer, and the limits on them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.dense.constraints import Box
from jaxatt.problems.hands_off.sparse_program import SparseSystem
from jaxatt.runtime.arrays import Flags, Floats


@dataclass(frozen=True)
class Support:
    """Free controls of a programme over `intervals`: k of them, in intervals and columns.

    columns : of the controls, b.  stages : intervals that are active, sorted.
    """

    intervals: int
    columns: int
    stages: tuple[int, ...]
    places: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, free: Flags) -> Support:
        """The support of flags (N, b)."""
        places = tuple((int(k), int(j)) for k, j in np.argwhere(free))
        count, columns = free.shape
        return cls(count, columns, tuple(sorted({k for k, _ in places})), places)

    @property
    def size(self) -> int:
        """Number of free controls."""
        return len(self.places)

    def spread(self, x: Array) -> Array:
        """Controls (N, b) of the free ones, which come first in x."""
        rows, columns = np.array(self.places, int).reshape(-1, 2).T
        whole = jnp.zeros((self.intervals, self.columns), x.dtype)
        return whole.at[rows, columns].set(x[: self.size])

    def free_of(self, u: Floats) -> Floats:
        """The free ones of controls (N, b)."""
        rows, columns = np.array(self.places, int).reshape(-1, 2).T
        return u[rows, columns]


def box_on(system: SparseSystem, support: Support, plant: Any, others: int) -> Box:
    """Bounds on the free controls where each has its own; `others` more variables have none."""
    columns = np.array([j for _, j in support.places], int)
    endless = jnp.full(others, jnp.inf)
    if system.bounds is None:
        own = jnp.full(support.size, jnp.inf)
        return Box(jnp.concatenate([-own, -endless]), jnp.concatenate([own, endless]))
    lower, upper = system.bounds(plant)
    return Box(
        jnp.concatenate([jnp.asarray(lower)[columns], -endless]),
        jnp.concatenate([jnp.asarray(upper)[columns], endless]),
    )


def margins_on(system: SparseSystem, support: Support, u: Array, plant: Any) -> Array:
    """Margins to limits beside those of `box_on`: on torques in active intervals, then on paths.

    u : (N, b).
    """
    path = system.margins(u, plant)
    if system.bounds is not None:
        return path
    own = system.stage_margins(u, plant)[np.array(support.stages, int)]
    return jnp.concatenate([own.ravel(), path])
