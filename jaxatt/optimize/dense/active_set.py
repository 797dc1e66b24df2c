"""One stabilised SQP step on the first-order conditions, by a primal-dual active-set iteration.

The quadratic programme of a stabilised SQP method (Wright 1998; Gill & Robinson 2013, A globally
convergent stabilized SQP method): the rows that bind satisfy

    H d + J' y + slope = 0,    rows + J d = mu (y - y0),

which is solvable however the rows depend on each other, and is Newton's step on the augmented
Lagrangian with penalty 1 / mu.  The active set is found by a primal-dual active-set iteration.
"""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.optimize.dense import arrays
from jaxatt.optimize.dense.arrays import namespace
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
    xp, n, q = namespace(x), x.shape[0], multipliers.shape[0]
    slope = weight * at.slope
    low, high = box.lower - x, box.upper - x

    def solve(binds: Array, side: Array) -> tuple[Array, Array]:
        """Step and multipliers for binding rows (q,) bool; side : (n,) -1, 0, 1 held or not."""
        held, masked = side != 0, xp.where(binds[:, None], at.jacobian, 0.0)
        rows = xp.where(binds, at.rows, 0.0)
        old = xp.where(binds, multipliers, 0.0)
        wanted = xp.where(held, xp.where(side < 0, low, high), -slope)
        if q <= n:
            d, y = _system(hessian, masked, mu, held, wanted, -rows - mu * old)
            return d, xp.where(binds, y, 0.0)
        # The range of J has n dimensions at most, and beyond it the multipliers are known.
        basis, factor = xp.linalg.qr(masked)
        right = -(basis.T @ rows) - mu * (basis.T @ old)
        d, z = _system(hessian, factor, mu, held, wanted, right)
        beyond = old + rows / mu
        return d, xp.where(binds, basis @ z + beyond - basis @ (basis.T @ beyond), 0.0)

    def again(carried: tuple[Array, ...]) -> tuple[Array, ...]:
        binds, side = carried[:2]
        d, y = solve(binds, side)
        pull = hessian @ d + slope + at.jacobian.T @ y
        trial = multipliers + (at.rows + at.jacobian @ d) / mu
        binds = equal | xp.where(binds, y < 0, trial < 0)
        stays = ((side < 0) & (pull > 0)) | ((side > 0) & (pull < 0))
        new = xp.where(d < low, -1, xp.where(d > high, 1, 0))
        side = xp.where(side != 0, xp.where(stays, side, 0), new)
        return binds, xp.where(box.lower >= box.upper, -1, side), d, y

    pull = slope + at.jacobian.T @ multipliers
    side = xp.where((low >= 0) & (pull > 0), -1, xp.where((high <= 0) & (pull < 0), 1, 0))
    side = xp.where(box.lower >= box.upper, -1, side)
    binds = equal | (multipliers + at.rows / mu < 0)
    none = xp.zeros_like(x), xp.zeros_like(multipliers)

    def same(old: tuple[Array, ...], new: tuple[Array, ...]) -> Array:
        return xp.all(old[0] == new[0]) & xp.all(old[1] == new[1])

    *_, d, y = arrays.repeat(_ROUNDS, again, (binds, side, *none), same)
    return Step(box.project(x + d), xp.where(equal, y, xp.minimum(y, 0.0)))


def _system(
    hessian: Array, jacobian: Array, mu: Array, held: Array, upper: Array, lower: Array
) -> tuple[Array, Array]:
    """Solve H d + J' y = upper, J d - mu y = lower; of held variables (n,) `upper` is the step."""
    xp, n, m = namespace(hessian), hessian.shape[0], jacobian.shape[0]
    top = xp.concatenate([hessian, jacobian.T], axis=1)
    top = xp.where(held[:, None], xp.eye(n, n + m, dtype=hessian.dtype), top)
    bottom = xp.concatenate([jacobian, -mu * xp.eye(m, dtype=hessian.dtype)], axis=1)
    matrix = xp.concatenate([top, bottom])
    answer = arrays.solve(matrix, xp.concatenate([upper, lower]))
    return answer[:n], answer[n:]


def fit(at: Local, multipliers: Array, x: Array, box: Box, equal: Array) -> Array:
    """Multipliers (q,) near the given ones that minimise the gradient of the Lagrangian at x.

    Where multipliers do not exist Newton's steps go to the solution all the same, and only
    multipliers that fit the new point show it.
    """
    xp, n, q = namespace(x), x.shape[0], multipliers.shape[0]
    slope = at.slope + at.jacobian.T @ multipliers
    stays = ((x <= box.lower) & (slope > 0)) | ((x >= box.upper) & (slope < 0))
    binds = equal | (multipliers < 0)
    matrix = xp.where(binds[:, None] & ~stays[None, :], at.jacobian, 0.0)
    basis, factor = xp.linalg.qr(matrix) if q > n else (None, matrix)
    gram = factor @ factor.T
    least = 1e-14 * xp.trace(gram) + 1e-300
    gram = gram + least * xp.eye(gram.shape[0], dtype=x.dtype)
    change = arrays.solve(gram, -(factor @ slope))
    change = change if basis is None else basis @ change
    fitted = multipliers + xp.where(xp.isfinite(change), change, 0.0)
    return xp.where(equal, fitted, xp.minimum(fitted, 0.0))
