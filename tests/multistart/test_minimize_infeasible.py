"""INFEASIBLE stands for a stationary point of the squared violation, in the constraints' units."""

import functools

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

import jaxatt
from jaxatt.optimize.status import Status

A = jnp.array([[1.0, 1.0], [1.0, -1.0], [2.0, 1.0]])


def objective(x, *_):
    return jnp.sum(x**2)


def lines(x, a, b):
    return a @ x - b


def test_three_lines_that_do_not_meet():
    found = jaxatt.minimize(
        objective, [0.0, 0.0], args=(A, jnp.array([3.0, 1.0, 6.0])), equality=lines
    )
    assert found.status == Status.INFEASIBLE
    np.testing.assert_allclose(found.x, [16.0 / 7.0, 8.0 / 7.0], rtol=1e-7)


@functools.cache
def random_cases():
    """Lines and half-planes that exclude each other, rows of sizes from 0.01 to 1e4."""
    rng = np.random.default_rng(1610)
    size = 10.0 ** rng.uniform(-2.0, 4.0, (8, 7, 1))
    return size * rng.normal(size=(8, 7, 3)), size[..., 0] * rng.normal(size=(8, 7))


@pytest.mark.parametrize("number", range(8))
def test_the_squared_violation_is_stationary_within_the_bounds(number):
    a, b = (jnp.asarray(part[number]) for part in random_cases())
    lower, upper = np.array([-0.3, -np.inf, -np.inf]), np.array([0.3, np.inf, 0.1])
    found = jaxatt.minimize(
        objective,
        np.zeros(3),
        args=(a, b),
        equality=first_rows,
        inequality=last_rows,
        lower=lower,
        upper=upper,
        max_iterations=2000,
    )
    assert found.status == Status.INFEASIBLE

    a, b = np.asarray(a), np.asarray(b)

    def amiss(x):
        rows = a @ x - b
        rows[5:] = np.minimum(rows[5:], 0.0)
        return 0.5 * rows @ rows, a.T @ rows

    value, gradient = amiss(found.x)
    step = found.x - np.clip(found.x - gradient / np.linalg.norm(a) ** 2, lower, upper)
    assert np.abs(step).max() < 1e-7 * max(1.0, np.abs(found.x).max())
    bounds = list(zip(lower, upper, strict=True))
    best = scipy.optimize.minimize(amiss, found.x, jac=True, bounds=bounds, method="L-BFGS-B")
    assert value <= best.fun * (1.0 + 1e-9)


def first_rows(x, a, b):
    return a[:5] @ x - b[:5]


def last_rows(x, a, b):
    return a[5:] @ x - b[5:]
