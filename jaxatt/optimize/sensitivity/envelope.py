"""Derivatives of an optimal objective by parameters, from the multipliers that a solver ended with.

They are those of the Lagrangian at fixed variables and multipliers (envelope theorem).  No KKT
matrix is solved, so that they exist where an answer itself has no derivative: where several
controls are equally good, or where limits that hold depend on each other.  They are as exact as
the answer is stationary.

Source: Fiacco (1983), "Introduction to sensitivity and stability analysis in nonlinear
programming", section 3.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.sensitivity.staged import StagedConditions, StagedPoint
from jaxatt.runtime.settings import QUICK_TO_COMPILE


@functools.partial(jax.jit, static_argnums=0, compiler_options=QUICK_TO_COMPILE)
def objective_along(
    conditions: StagedConditions, point: StagedPoint, args: Any, along: Any
) -> Array:
    """Derivatives (P,) of the objective along directions (P, ...) of the parameters.

    point : with the multipliers of the solver; its costates are not used, but follow from them.
    """
    whole = point._replace(costates=conditions.system(point, args).model.costates)
    kept = jax.tree.map(jnp.isfinite, conditions.margins(point, args))
    rest = conditions.zero(point)

    def worth(args: Any) -> Array:
        return conditions.lagrangian(whole, rest, args, kept)

    return jax.vmap(lambda one: jax.jvp(worth, (args,), (one,))[1])(along)
