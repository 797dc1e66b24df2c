"""Few variables under thousands of constraints: the optimum is that of HiGHS, or published."""

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

import jaxatt
from jaxatt.optimize.dense.active_set import fit, newton_step
from jaxatt.optimize.dense.constraints import Box, constraints_of
from jaxatt.optimize.dense.local import Local
from jaxatt.optimize.status import Status

ROWS = 2000
COST = np.array([1.0, 2.0])


def cost(x, a, b):
    return jnp.asarray(COST) @ x


def above(x, a, b):
    return a @ x - b


def half_planes(kind):
    rng = np.random.default_rng(2026)
    a = rng.normal(size=(ROWS, 2))
    if kind == "vertex":
        a = np.where((a @ COST)[:, None] < 0, -a, a)
        return a, a @ np.array([3.0, -1.0])
    a = np.repeat(a[::2], 2, axis=0) if kind == "twice" else a
    return a, -rng.uniform(1.0, 2.0, ROWS // 2).repeat(2)


@pytest.mark.parametrize("kind", ["plain", "twice", "vertex"])
def test_thousands_of_half_planes_degenerate_or_not(kind):
    a, b = half_planes(kind)
    found = jaxatt.minimize(cost, [0.0, 0.0], (a, b), inequality=above)
    best = scipy.optimize.linprog(COST, A_ub=-a, b_ub=-b, bounds=(None, None))
    assert found.status is Status.CONVERGED
    np.testing.assert_allclose(found.objective, best.fun, rtol=1e-7)
    assert (a @ found.x - b).min() > -1e-9
    pull = a.T @ found.multipliers.inequality
    np.testing.assert_allclose(pull, COST, atol=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_a_step_under_many_rows_solves_the_equations_of_those_that_bind(seed):
    rng = np.random.default_rng(seed)
    n, q, mu = 3, 40, np.float64(10.0 ** rng.uniform(-6.0, 0.0))
    equal = np.arange(q) < 2
    jacobian, rows = rng.normal(size=(q, n)), rng.normal(size=q)
    jacobian[5] = jacobian[6]
    at = Local(np.float64(0.0), rows, rng.normal(size=n), jacobian)
    root = rng.normal(size=(n, n))
    hessian, old = root @ root.T + np.eye(n), np.where(equal, 1.0, -1.0) * rng.uniform(size=q)
    box, one = Box(np.full(n, -1e9), np.full(n, 1e9)), np.float64(1.0)
    x, y = newton_step(np.zeros(n), at, one, hessian, old, mu, constraints_of(box, 2, q - 2))
    binds = equal | (y < 0)
    assert binds.sum() > 2
    np.testing.assert_allclose(
        hessian @ x + at.slope + jacobian.T @ y, 0.0, atol=1e-7 * (1.0 + np.abs(y).max())
    )
    np.testing.assert_allclose((rows + jacobian @ x)[binds], (mu * (y - old))[binds], atol=1e-7)


def test_multipliers_that_fit_are_the_nearest_ones():
    rng = np.random.default_rng(5)
    n, q = 3, 30
    jacobian, slope, old = rng.normal(size=(q, n)), rng.normal(size=n), rng.normal(size=q)
    at = Local(np.float64(0.0), np.zeros(q), slope, jacobian)
    box = Box(np.full(n, -np.inf), np.full(n, np.inf))
    found = fit(at, old, np.zeros(n), constraints_of(box, q, 0))
    nearest = old - np.linalg.pinv(jacobian.T) @ (slope + jacobian.T @ old)
    np.testing.assert_allclose(found, nearest, atol=1e-9)
