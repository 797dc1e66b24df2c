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

    def solve(binds: Array, side: Array) -> tuple[Array, Array]:
        """Step and multipliers for binding rows (q,) bool; side : (n,) -1, 0, 1 held or not."""
        held, masked = side != 0, jnp.where(binds[:, None], at.jacobian, 0.0)
        rows = jnp.where(binds, at.rows, 0.0)
        old = jnp.where(binds, multipliers, 0.0)
        wanted = jnp.where(held, jnp.where(side < 0, low, high), -slope)
        if q <= n:
            d, y = _system(hessian, masked, mu, held, wanted, -rows - mu * old)
            return d, jnp.where(binds, y, 0.0)
        # The range of J has n dimensions at most, and beyond it the multipliers are known.
        basis, factor = jnp.linalg.qr(masked)
        right = -(basis.T @ rows) - mu * (basis.T @ old)
        d, z = _system(hessian, factor, mu, held, wanted, right)
        beyond = old + rows / mu
        return d, jnp.where(binds, basis @ z + beyond - basis @ (basis.T @ beyond), 0.0)

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


def _system(
    hessian: Array, jacobian: Array, mu: Array, held: Array, upper: Array, lower: Array
) -> tuple[Array, Array]:
    """Solve H d + J' y = upper, J d - mu y = lower; of held variables (n,) `upper` is the step."""
    n, m = hessian.shape[0], jacobian.shape[0]
    top = jnp.concatenate([hessian, jacobian.T], axis=1)
    top = jnp.where(held[:, None], jnp.eye(n, n + m, dtype=hessian.dtype), top)
    bottom = jnp.concatenate([jacobian, -mu * jnp.eye(m, dtype=hessian.dtype)], axis=1)
    matrix = jnp.concatenate([top, bottom])
    answer = jnp.linalg.solve(matrix, jnp.concatenate([upper, lower]))
    return answer[:n], answer[n:]


def fit(at: Local, multipliers: Array, x: Array, box: Box, equal: Array) -> Array:
    """Multipliers (q,) near the given ones that minimise the gradient of the Lagrangian at x.

    Where multipliers do not exist Newton's steps go to the solution all the same, and only
    multipliers that fit the new point show it.
    """
    n, q = x.shape[0], multipliers.shape[0]
    slope = at.slope + at.jacobian.T @ multipliers
    stays = ((x <= box.lower) & (slope > 0)) | ((x >= box.upper) & (slope < 0))
    binds = equal | (multipliers < 0)
    matrix = jnp.where(binds[:, None] & ~stays[None, :], at.jacobian, 0.0)
    basis, factor = jnp.linalg.qr(matrix) if q > n else (None, matrix)
    gram = factor @ factor.T
    least = 1e-14 * jnp.trace(gram) + 1e-300
    gram = gram + least * jnp.eye(gram.shape[0], dtype=x.dtype)
    change = jnp.linalg.solve(gram, -(factor @ slope))
    change = change if basis is None else basis @ change
    fitted = multipliers + jnp.where(jnp.isfinite(change), change, 0.0)
    return jnp.where(equal, fitted, jnp.minimum(fitted, 0.0))
