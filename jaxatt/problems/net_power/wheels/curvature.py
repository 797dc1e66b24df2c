"""Exact curvature of intervals, by central differences of their linearisation.

The closed form of `hessian` leaves out terms of h^4 and what external torques add to second order:
good for the steps of a solver, not for derivatives of its answer.  Differentiating the
linearisation once more takes a compiler minutes; its differences are right to nine digits.  In the
chart of an attitude two turns in succession add up to second order but for an antisymmetric part,
which goes with the antisymmetric part of the matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.state_manifold import retract
from jaxatt.problems.net_power.wheels.linearisation import linearisation
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters, WheelStage
from jaxatt.problems.net_power.wheels.rows import Rows

_STEP = 1e-5
"""Of error coordinates and controls, all of order one."""


def exact_hessian(
    rows: Rows,
    x: Array,
    u: Array,
    x_next: Array,
    stage: WheelStage,
    p: WheelsParameters,
    costate: Array,
    kept: Any,
) -> Array:
    """See `OptimalControlProgram.lagrangian_hessian`."""

    def slopes(x: Array, u: Array) -> Array:
        found = linearisation(rows, x, u, x_next, stage, p)
        return jnp.concatenate([found.cost[None], found.dynamics])

    weights = jnp.concatenate([jnp.ones(1), costate])
    return _differenced(rows, slopes, weights, x, u)


def exact_path_hessian(
    rows: Rows, x: Array, u: Array, stage: WheelStage, p: WheelsParameters, dual: Array, kept: Any
) -> Array:
    """See `OptimalControlProgram.path_hessian`."""

    def slopes(x: Array, u: Array) -> Array:
        found = linearisation(rows, x, u, x, stage, p)
        assert found.path_slope is not None
        return found.path_slope

    return _differenced(rows, slopes, dual, x, u)


def _differenced(
    rows: Rows, slopes: Callable[[Array, Array], Array], weights: Array, x: Array, u: Array
) -> Array:
    """Symmetric derivative (z, z) of weighted (r,) slopes (r, z), functions of x and u."""
    n = rows.form.error_size
    ways = _STEP * jnp.eye(n + u.shape[0])
    both = jnp.concatenate([ways, -ways])
    # A loop, which ends with all slopes: XLA would compute them anew for every one of the sums.
    ends = lax.map(lambda z: slopes(retract(x, z[:n]), u + z[n:]), both)
    change = (ends[: len(ways)] - ends[len(ways) :]) / (2.0 * _STEP)
    matrix = jnp.sum(weights[None, :, None] * change, axis=1)
    return 0.5 * (matrix + matrix.T)
