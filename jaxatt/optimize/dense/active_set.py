"""One stabilised SQP step on the first-order conditions, by a primal-dual active-set iteration.

The quadratic programme of a stabilised SQP method (Wright 1998; Gill & Robinson 2013, A globally
convergent stabilized SQP method): the rows that bind satisfy

    H d + J' y + slope = 0,    rows + J d = mu (y - y0),

which is solvable however the rows depend on each other, and is Newton's step on the augmented
Lagrangian with penalty 1 / mu.  The active set is found by a primal-dual active-set iteration.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.optimize.dense.functions import Local
from jaxatt.optimize.dense.residuals import Box

_ROUNDS = 9


class Step(NamedTuple):
    """Result of a step: x (n,) inside the box, and multipliers (q,) of the scaled rows."""

    x: Array
    multipliers: Array


def newton_step(
    x: Array,
    at: Local,
    weight: Array,
    hessian: Array,
    multipliers: Array,
    mu: Array,
    box: Box,
    equal: Array,
) -> Step:
    """Compute a stabilised Newton step from x, (n,).

    weight : () of the objective.  hessian : (n, n).  multipliers : (q,), y0.  mu : () > 0.
    """
    n, q = x.shape[0], multipliers.shape[0]
    slope = weight * at.slope
    low, high = box.lower - x, box.upper - x
    identity = jnp.eye(q, dtype=x.dtype)

    def solve(binds: Array, side: Array) -> tuple[Array, Array]:
        """Step and multipliers for binding rows (q,) bool; side : (n,) -1, 0, 1 held or not."""
        held = side != 0
        top = jnp.concatenate([hessian, at.jacobian.T], axis=1)
        fixed = jnp.eye(n, n + q, dtype=x.dtype)
        top = jnp.where(held[:, None], fixed, top)
        bottom = jnp.concatenate([at.jacobian, -mu * identity], axis=1)
        unused = jnp.concatenate([jnp.zeros((q, n), x.dtype), identity], axis=1)
        bottom = jnp.where(binds[:, None], bottom, unused)
        target = jnp.where(side < 0, low, high)
        right = jnp.concatenate(
            [
                jnp.where(held, target, -slope),
                jnp.where(binds, -at.rows - mu * multipliers, 0.0),
            ]
        )
        answer = jnp.linalg.solve(jnp.concatenate([top, bottom]), right)
        return answer[:n], answer[n:]

    def again(_: int, carried: tuple[Array, ...]) -> tuple[Array, ...]:
        binds, side = carried[:2]
        d, y = solve(binds, side)
        pull = hessian @ d + slope + at.jacobian.T @ y
        trial = multipliers + (at.rows + at.jacobian @ d) / mu
        binds = equal | jnp.where(binds, y < 0, trial < 0)
        stays = ((side < 0) & (pull > 0)) | ((side > 0) & (pull < 0))
        new = jnp.where(d < low, -1, jnp.where(d > high, 1, 0))
        side = jnp.where(side != 0, jnp.where(stays, side, 0), new)
        return binds, jnp.where(box.lower >= box.upper, -1, side), d, y

    pull = slope + at.jacobian.T @ multipliers
    side = jnp.where((low >= 0) & (pull > 0), -1, jnp.where((high <= 0) & (pull < 0), 1, 0))
    side = jnp.where(box.lower >= box.upper, -1, side)
    binds = equal | (multipliers + at.rows / mu < 0)
    none = jnp.zeros_like(x), jnp.zeros_like(multipliers)
    *_, d, y = lax.fori_loop(0, _ROUNDS, again, (binds, side, *none))
    return Step(box.project(x + d), jnp.where(equal, y, jnp.minimum(y, 0.0)))


def fit(at: Local, multipliers: Array, x: Array, box: Box, equal: Array) -> Array:
    """Multipliers (q,) near the given ones that minimise the gradient of the Lagrangian at x.

    Where multipliers do not exist Newton's steps go to the solution all the same, and only
    multipliers that fit the new point show it.
    """
    slope = at.slope + at.jacobian.T @ multipliers
    stays = ((x <= box.lower) & (slope > 0)) | ((x >= box.upper) & (slope < 0))
    binds = equal | (multipliers < 0)
    matrix = jnp.where(binds[:, None] & ~stays[None, :], at.jacobian, 0.0)
    gram = matrix @ matrix.T
    q = gram.shape[0]
    least = 1e-14 * jnp.trace(gram) + 1e-300
    change = jnp.linalg.solve(gram + least * jnp.eye(q, dtype=x.dtype), -(matrix @ slope))
    fitted = multipliers + jnp.where(jnp.isfinite(change), change, 0.0)
    return jnp.where(equal, fitted, jnp.minimum(fitted, 0.0))
