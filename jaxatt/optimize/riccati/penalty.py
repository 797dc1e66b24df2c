"""Quadratic penalty models of the constraints of a staged programme.

The Powell-Hestenes-Rockafellar terms of `penalty`, in Gauss-Newton form: the curvature of the rows
themselves is left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.augmented_lagrangian.penalty import pushed
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.riccati.recursion import Trajectory, product


class Rows(NamedTuple):
    """Equalities (q,), zero when satisfied, and inequalities (p,), non-negative when satisfied."""

    equality: Array
    inequality: Array


class PenaltyModel(NamedTuple):
    """Quadratic penalty model in z, the error state with or without controls.

    hessian : (z, z).  gradient : (z,).  estimates : first-order multiplier estimates.
    """

    hessian: Array
    gradient: Array
    estimates: Rows


def effective(weight: Array, penalty: Array, shape: tuple[int, ...]) -> Array:
    """Penalty of every row: its own weight if that is finite, `penalty` if it is hard."""
    weight = jnp.broadcast_to(weight, shape)
    return jnp.where(jnp.isinf(weight), penalty, weight)


def differentiated(rows: Callable[[Array], Rows], at: Array) -> tuple[Rows, Array]:
    """Rows at z = `at`, (z,), and their derivatives (q + p, z)."""
    values = rows(at)
    if values.equality.shape[0] + values.inequality.shape[0] == 0:
        return values, jnp.zeros((0, at.shape[0]), at.dtype)
    return values, jnp.asarray(jax.jacfwd(lambda z: jnp.concatenate(rows(z)))(at))


def stage_rows(program: OptimalControlProgram, x: Array, u: Array, stage: Any, args: Any) -> Rows:
    """Constraints of one stage."""
    return Rows(program.equalities(x, u, stage, args), program.inequalities(x, u, stage, args))


def final_rows(program: OptimalControlProgram, x: Array, args: Any) -> Rows:
    """Constraints on the last state."""
    return Rows(program.final_equalities(x, args), program.final_inequalities(x, args))


def rows_along(program: OptimalControlProgram, flown: Trajectory, args: Any) -> tuple[Rows, Array]:
    """Constraints of all stages and their derivatives (N, q + p, n + b).

    A loop of its own for the same reason as `riccati.derivatives_along`.
    """
    n = program.error_size

    def at(_: None, inputs: tuple[Array, Array, Any]) -> tuple[None, tuple[Rows, Array]]:
        x, u, stage = inputs

        def moved(z: Array) -> Rows:
            return stage_rows(program, program.retract(x, z[:n]), u + z[n:], stage, args)

        return None, differentiated(moved, jnp.zeros(n + u.shape[0], u.dtype))

    return lax.scan(at, None, (flown.x, flown.u, program.stages(args)))[1]


def models_along(
    program: OptimalControlProgram,
    flown: Trajectory,
    multipliers: Rows,
    penalty: Array,
    stage_penalty: Array,
    args: Any,
) -> tuple[Rows, PenaltyModel]:
    """Constraints of all stages and their penalty models, leading axis N."""

    def at(_: None, inputs: tuple[Rows, Array, Rows, Any]) -> tuple[None, PenaltyModel]:
        values, jacobian, held, stage = inputs
        weight = program.equality_weights(stage, args)
        return None, penalty_model(values, jacobian, held, weight, penalty, stage_penalty)

    rows, jacobians = rows_along(program, flown, args)
    inputs = (rows, jacobians, multipliers, program.stages(args))
    return rows, lax.scan(at, None, inputs)[1]


def penalty_model(
    values: Rows,
    jacobian: Array,
    multipliers: Rows,
    weight: Array,
    penalty: Array,
    stage_penalty: Array,
) -> PenaltyModel:
    """Penalty model of rows from their values and derivatives (q + p, z).

    weight : (q,) or (), inf for hard equalities.  penalty, stage_penalty : () of the hard
    equalities and of the inequalities.
    """
    w = effective(weight, penalty, values.equality.shape)
    estimates = Rows(
        multipliers.equality + w * values.equality,
        pushed(multipliers.inequality, stage_penalty, values.inequality),
    )
    count, size = jacobian.shape
    if count == 0:
        zero = jnp.zeros((size, size), jacobian.dtype)
        return PenaltyModel(zero, zero[0], estimates)
    active = jnp.where(estimates.inequality > 0, stage_penalty, 0.0)
    scale = jnp.concatenate([w, active])
    force = jnp.concatenate([estimates.equality, -estimates.inequality])
    hessian = product(jacobian.T, scale[:, None] * jacobian)
    return PenaltyModel(hessian, jnp.sum(jacobian * force[:, None], axis=0), estimates)
