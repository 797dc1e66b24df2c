"""Least effort on a frozen support as a small programme in standard form.

Magnitudes are variables of their own, t >= quantity and t >= - quantity, so that quantities of zero
are corners with multipliers and not points without derivatives.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.dense.functions import Functions
from jaxatt.problems.hands_off.sparse_program import SparseSystem
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Flags, Floats


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class EffortArguments:
    """What the least effort depends on.

    plant : the system's own parameters.  quantities : (r, b), per unit of the scaled controls,
    whose magnitudes over all intervals are the effort.  scale : (b,), the system's controls for a
    unit of the scaled ones.
    """

    plant: object
    quantities: Array
    scale: Array


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

    def spread(self, x: Array) -> Array:
        """Controls (N, b) of the free ones, which come first in x."""
        rows, columns = np.array(self.places, int).reshape(-1, 2).T
        whole = jnp.zeros((self.intervals, self.columns), x.dtype)
        return whole.at[rows, columns].set(x[: len(self.places)])

    def free_of(self, u: Floats) -> Floats:
        """The free ones of controls (N, b)."""
        rows, columns = np.array(self.places, int).reshape(-1, 2).T
        return u[rows, columns]


@functools.cache
def effort_functions(system: SparseSystem, support: Support) -> Functions:
    """Effort, rows at the end, and limits, of free controls and then magnitudes (stage, r)."""
    stages = np.array(support.stages, int)
    size = len(support.places)

    def objective(x: Array, args: EffortArguments) -> Array:
        return jnp.sum(x[size:])

    def equality(x: Array, args: EffortArguments) -> Array:
        return system.rows(support.spread(x), args.plant)

    def inequality(x: Array, args: EffortArguments) -> Array:
        u = support.spread(x)
        quantity = (u[stages] @ args.quantities.T).ravel()
        return jnp.concatenate(
            [
                x[size:] - quantity,
                x[size:] + quantity,
                system.stage_margins(u, args.plant)[stages].ravel(),
                system.margins(u, args.plant),
            ]
        )

    return Functions(objective, equality, inequality)


def effort_arguments(task: SparseTask, plant: object) -> EffortArguments:
    """Arguments of a task's least effort, in its physical unit."""
    rows = np.asarray(task.arguments.effort_map) * task.effort_unit
    used = np.any(rows != 0.0, axis=1)
    return EffortArguments(plant, jnp.asarray(rows[used]), jnp.asarray(task.control_unit))
