"""Exact curvature of stages, by central differences of their linearisation.

What a programme gives as its curvature may leave out what is dear: good for the steps of a solver,
not for derivatives of its answer.  Differentiating the linearisation once more takes a compiler
minutes; its differences are right to nine digits.  In a chart where two steps in succession add up
to second order but for an antisymmetric part, as turns do, that part goes with the antisymmetric
part of the matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.optimal_control import OptimalControlProgram, linearisation

_STEP = 1e-5
"""Of error coordinates and controls, all of order one."""


def exact_hessian(
    program: OptimalControlProgram,
    x: Array,
    u: Array,
    x_next: Array,
    stage: Any,
    args: Any,
    costate: Array,
    kept: Any,
) -> Array:
    """See `OptimalControlProgram.lagrangian_hessian`."""

    def slopes(x: Array, u: Array) -> Array:
        found = linearisation(program, x, u, x_next, stage, args)
        return jnp.concatenate([found.cost[None], found.dynamics])

    weights = jnp.concatenate([jnp.ones(1), costate])
    return _differenced(program, slopes, weights, x, u)


def exact_path_hessian(
    program: OptimalControlProgram,
    x: Array,
    u: Array,
    stage: Any,
    args: Any,
    dual: Array,
    kept: Any,
) -> Array:
    """See `OptimalControlProgram.path_hessian`; the linearisation has to give the path's slope."""

    def slopes(x: Array, u: Array) -> Array:
        found = linearisation(program, x, u, x, stage, args)
        assert found.path_slope is not None
        return found.path_slope

    return _differenced(program, slopes, dual, x, u)


def _differenced(
    program: OptimalControlProgram,
    slopes: Callable[[Array, Array], Array],
    weights: Array,
    x: Array,
    u: Array,
) -> Array:
    """Symmetric derivative (z, z) of weighted (r,) slopes (r, z), functions of x and u."""
    n = program.error_size
    change = differenced(lambda z: slopes(program.retract(x, z[:n]), u + z[n:]), n + u.shape[0])
    matrix = jnp.sum(weights[:, None, None] * change, axis=0)
    return 0.5 * (matrix + matrix.T)


def differenced(of: Callable[[Array], Array], size: int) -> Array:
    """Derivatives (..., size) of an array at zero, by central differences."""
    ways = _STEP * jnp.eye(size)
    # A loop, which ends with all values: XLA would compute them anew for every one of the sums.
    ends = lax.map(of, jnp.concatenate([ways, -ways]))
    return jnp.moveaxis((ends[:size] - ends[size:]) / (2.0 * _STEP), 0, -1)
