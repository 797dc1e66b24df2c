"""Gauss-Newton step on an augmented Lagrangian, as an optax gradient transformation.

The Hessian model is block diagonal plus few rows: H = diag(B_1 .. B_N) + J' diag(w) J.  The blocks
hold the curvature of everything that belongs to one stage, the rows that of the constraints which
couple the stages.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.optimize.small_systems import invert_spd_blocks

if TYPE_CHECKING:
    import optax


class LocalModel(NamedTuple):
    """Curvature of a merit function at a point, for N stages of b variables each.

    blocks : (N, b, b), positive semidefinite.
    rows : (m, N, b), derivatives of the coupling constraints.
    weights : (m,), non-negative weights of the rows.
    free : (N, b), 1 where a variable may move.
    """

    blocks: Array
    rows: Array
    weights: Array
    free: Array


class GaussNewtonState(NamedTuple):
    """State of the line search."""

    line_search: optax.OptState


def _solve_low_rank(gradient: Array, model: LocalModel) -> Array:
    inverse = invert_spd_blocks(model.blocks)
    rows = model.rows * jnp.sqrt(model.weights)[:, None, None]
    scaled_gradient = jnp.einsum("kij,kj->ki", inverse, gradient)
    scaled_rows = jnp.einsum("kij,mkj->mki", inverse, rows)
    capacitance = jnp.einsum("mki,nki->mn", rows, scaled_rows)
    capacitance = capacitance + jnp.eye(rows.shape[0], dtype=rows.dtype)
    factor = jax.scipy.linalg.cho_factor(capacitance)
    shares = jax.scipy.linalg.cho_solve(factor, jnp.einsum("mki,ki->m", rows, scaled_gradient))
    return scaled_gradient - jnp.einsum("m,mki->ki", shares, scaled_rows)


def _solve_dense(gradient: Array, model: LocalModel) -> Array:
    stages, size = gradient.shape
    n = stages * size
    rows = model.rows.reshape(-1, n)
    index = jnp.arange(stages)
    dense = jnp.zeros((stages, size, stages, size), gradient.dtype)
    dense = dense.at[index, :, index, :].set(model.blocks).reshape(n, n)
    dense = dense + jnp.einsum("mi,m,mj->ij", rows, model.weights, rows)
    factor = jax.scipy.linalg.cho_factor(dense)
    return jax.scipy.linalg.cho_solve(factor, gradient.reshape(n)).reshape(stages, size)


def gauss_newton(
    damping: float = 1e-9, backtracking_steps: int = 10
) -> optax.GradientTransformationExtraArgs:
    """Gauss-Newton direction from a `LocalModel`, followed by optax's backtracking line search.

    `update` takes the keywords `model`, `value`, `grad` and `value_fn`, the last three as optax's
    line searches do.  damping : added to the diagonal of every block.
    """
    import optax

    line_search = optax.scale_by_backtracking_linesearch(
        max_backtracking_steps=backtracking_steps, decrease_factor=0.4, increase_factor=1e9
    )

    def init(params: Array) -> GaussNewtonState:
        return GaussNewtonState(line_search.init(params))

    def update(
        updates: Array,
        state: GaussNewtonState,
        params: Array | None = None,
        *,
        model: LocalModel,
        value: Array,
        grad: Array,
        value_fn: Callable[[Array], Array],
    ) -> tuple[Array, GaussNewtonState]:
        free = model.free
        gradient = updates * free
        size = gradient.shape[1]
        eye = jnp.eye(size, dtype=gradient.dtype)
        blocks = model.blocks * free[:, :, None] * free[:, None, :]
        blocks = blocks + eye[None] * (damping + (1.0 - free))[:, :, None]
        masked = LocalModel(blocks, model.rows * free[None], model.weights, free)
        few_rows = model.rows.shape[0] <= gradient.size // 2 and size <= 8
        direction = -(_solve_low_rank if few_rows else _solve_dense)(gradient, masked)
        step, search_state = line_search.update(
            direction, state.line_search, params, value=value, grad=grad, value_fn=value_fn
        )
        return step, GaussNewtonState(search_state)

    return optax.GradientTransformationExtraArgs(init, update)
