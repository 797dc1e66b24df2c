"""Least effort on a frozen support as a small programme in standard form.

Magnitudes of two-sided quantities are variables of their own, t >= quantity and t >= - quantity, so
that quantities of zero are corners with multipliers and not points without derivatives.  Thrusters
push one way only: what they spend is linear in how long their valves are open.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.dense.functions import Functions
from jaxatt.problems.hands_off.limit_names import bound_names, margin_names
from jaxatt.problems.hands_off.small_programme import SmallProgramme
from jaxatt.problems.hands_off.sparse_program import SparseSystem
from jaxatt.problems.hands_off.support import Support, margins_on
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class EffortArguments:
    """What the least effort depends on.

    plant : the system's own parameters.  quantities : (r, b), per unit of the scaled controls,
    whose magnitudes over all intervals are the effort, beside `charges`, (b,), per unit of controls
    that cannot be negative.  scale : (b,), the system's controls for a unit of the scaled ones.
    """

    plant: object
    quantities: Array
    charges: Array
    scale: Array


@functools.cache
def effort_functions(system: SparseSystem, support: Support) -> Functions:
    """Effort, rows at the end, and limits, of free controls and then magnitudes (stage, r)."""
    stages = np.array(support.stages, int)
    columns = np.array([j for _, j in support.places], int)
    size = support.size

    def objective(x: Array, args: EffortArguments) -> Array:
        return jnp.sum(x[size:]) + jnp.sum(args.charges[columns] * x[:size])

    def equality(x: Array, args: EffortArguments) -> Array:
        return system.rows(support.spread(x), args.plant)

    def inequality(x: Array, args: EffortArguments) -> Array:
        u = support.spread(x)
        quantity = (u[stages] @ args.quantities.T).ravel()
        own = margins_on(system, support, u, args.plant)
        return jnp.concatenate([x[size:] - quantity, x[size:] + quantity, own])

    return Functions(objective, equality, inequality)


def effort_arguments(task: SparseTask, plant: object) -> EffortArguments:
    """Arguments of a task's least effort, in its physical unit."""
    rows = np.asarray(task.arguments.effort_map) * task.effort_unit
    rows = rows[np.any(rows != 0.0, axis=1)]
    linear = np.all((rows == 0.0) | ((rows > 0.0) & task.one_sided), axis=1)
    return EffortArguments(
        plant,
        jnp.asarray(rows[~linear]),
        jnp.asarray(rows[linear].sum(axis=0)),
        jnp.asarray(task.control_unit),
    )


def effort_programme(
    task: SparseTask, support: Support, u: Floats, plant: object
) -> SmallProgramme:
    """Least effort of a task on a support, from scaled controls u (N, b)."""
    args = effort_arguments(task, plant)
    size = np.abs(u[list(support.stages)] @ np.asarray(args.quantities).T)
    pairs = [(k, r) for k in support.stages for r in range(len(args.quantities))]
    names = [f"quantity {r} {side} 0, interval {k}" for side in (">=", "<=") for k, r in pairs]
    names += margin_names(task, support) + bound_names(task, support, len(pairs))
    return SmallProgramme(
        effort_functions(task.system, support),
        effort_arguments,
        np.concatenate([support.free_of(u), size.ravel()]),
        tuple(names),
        "effort",
        task.effort_name,
    )
