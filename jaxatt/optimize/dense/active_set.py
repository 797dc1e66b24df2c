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
from jaxatt.optimize.dense.arrays import certain, namespace, no
from jaxatt.optimize.dense.constraints import Constraints
from jaxatt.optimize.dense.local import Local

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
    constraints: Constraints,
) -> Step:
    """Compute a stabilised Newton step from x, (n,).

    weight : () of the objective.  hessian : (n, n).  multipliers : (q,), y0.  mu : () > 0.
    """
    xp, box, equal, n = namespace(x), constraints.box, constraints.equal, x.shape[0]
    slope = weight * at.slope
    low, high = box.lower - x, box.upper - x
    pressed = multipliers + at.rows / mu

    def solve(binds: Array, side: Array, free: bool) -> tuple[Array, Array]:
        """Step and multipliers for binding rows (q,) bool; side : (n,) -1, 0, 1 held or not."""
        held = side != 0
        jacobian, rows, old = arrays.rows_where(binds, at.jacobian, at.rows, multipliers)
        wanted = -slope if free else xp.where(held, xp.where(side < 0, low, high), -slope)
        own = None if free else held
        if jacobian.shape[0] <= n:
            d, y = _system(hessian, jacobian, mu, own, wanted, -rows - mu * old)
            return d, arrays.put_back(binds, y)
        # The range of J has n dimensions at most, and beyond it the multipliers are known.
        basis, factor = xp.linalg.qr(jacobian)
        right = -(rows.dot(basis)) - mu * old.dot(basis)
        d, z = _system(hessian, factor, mu, own, wanted, right)
        beyond = old + rows / mu
        return d, arrays.put_back(binds, beyond + basis.dot(z - beyond.dot(basis)))

    def again(carried: tuple[Array, ...]) -> tuple[Array, ...]:
        binds, side = carried[:2]
        free = constraints.unbounded or certain(no(xp.any(side)))
        d, y = solve(binds, side, free)
        if len(equal) > constraints.equalities:
            trial = pressed + at.jacobian.dot(d) / mu
            binds = equal | (xp.where(binds, y, trial) < 0)
        if constraints.unbounded or (free and certain(no(xp.any((d < low) | (d > high))))):
            return binds, side, d, y
        pull = hessian.dot(d) + slope + y.dot(at.jacobian)
        stays = ((side < 0) & (pull > 0)) | ((side > 0) & (pull < 0))
        new = xp.where(d < low, -1, xp.where(d > high, 1, 0))
        side = xp.where(side != 0, xp.where(stays, side, 0), new)
        return binds, xp.where(constraints.pinned, -1, side), d, y

    side = xp.zeros(n, int)
    if not certain(no(constraints.bounded & xp.any((low >= 0) | (high <= 0)))):
        pull = slope + multipliers.dot(at.jacobian)
        side = xp.where((low >= 0) & (pull > 0), -1, xp.where((high <= 0) & (pull < 0), 1, 0))
        side = xp.where(constraints.pinned, -1, side)
    binds = equal | (pressed < 0)
    none = xp.zeros_like(x), xp.zeros_like(multipliers)

    def same(old: tuple[Array, ...], new: tuple[Array, ...]) -> bool:
        return arrays.same(old[0], new[0]) and arrays.same(old[1], new[1])

    *_, d, y = arrays.repeat(_ROUNDS, again, (binds, side, *none), same)
    return Step(constraints.project(x + d), xp.minimum(y, constraints.most))


def _system(
    hessian: Array, jacobian: Array, mu: Array, held: Array | None, upper: Array, lower: Array
) -> tuple[Array, Array]:
    """Solve H d + J' y = upper, J d - mu y = lower; of held variables (n,) `upper` is the step."""
    xp, n, m = namespace(hessian), hessian.shape[0], jacobian.shape[0]
    top = hessian if m == 0 else xp.concatenate([hessian, jacobian.T], axis=1)
    if held is not None:
        top = xp.where(held[:, None], xp.eye(n, n + m, dtype=hessian.dtype), top)
    if m == 0:
        return arrays.solve(top, upper), lower
    bottom = xp.concatenate([jacobian, -mu * xp.eye(m, dtype=hessian.dtype)], axis=1)
    matrix = xp.concatenate([top, bottom])
    answer = arrays.solve(matrix, xp.concatenate([upper, lower]))
    return answer[:n], answer[n:]


def fit(at: Local, multipliers: Array, x: Array, constraints: Constraints) -> Array:
    """Multipliers (q,) near the given ones that minimise the gradient of the Lagrangian at x.

    Where multipliers do not exist Newton's steps go to the solution all the same, and only
    multipliers that fit the new point show it.
    """
    xp, n, box = namespace(x), x.shape[0], constraints.box
    slope = at.slope + multipliers.dot(at.jacobian)
    binds = constraints.equal | (multipliers < 0)
    (matrix,) = arrays.rows_where(binds, at.jacobian)
    if not constraints.unbounded:
        stays = ((x <= box.lower) & (slope > 0)) | ((x >= box.upper) & (slope < 0))
        matrix = xp.where(stays[None, :], 0.0, matrix)
    basis, factor = xp.linalg.qr(matrix) if matrix.shape[0] > n else (None, matrix)
    gram = factor.dot(factor.T)
    least = 1e-14 * xp.trace(gram) + 1e-300
    gram = gram + least * xp.eye(gram.shape[0], dtype=x.dtype)
    change = arrays.solve(gram, -factor.dot(slope))
    change = arrays.put_back(binds, change if basis is None else basis.dot(change))
    fitted = multipliers + xp.where(xp.isfinite(change), change, 0.0)
    return xp.minimum(fitted, constraints.most)
