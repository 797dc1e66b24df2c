"""Least effort within limits against linear programming and a general solver of SciPy."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.least_effort.primal_dual import LeastEffort
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.solver import solve
from jaxatt.optimize.status import Status

ROWS, STAGES, SIZE = 4, 6, 2
SCHEDULE = Schedule(smoothing_start=0.1, smoothing_factor=0.45, smoothing_end=1e-5)
LIMITS = np.array([[1.0, 0.0], [0.0, 1.0], [0.7, 0.7]])


@functools.partial(jax.jit, static_argnames="bent")
@functools.partial(jax.vmap, in_axes=(0, 0, 0, 0, 0, None, None))
def run_at(matrix, target, u, free, row_weight, bent, price):
    """Rows A u - t, bent by 0.2 sin(A u), with the effort of magnitudes at a price."""

    def rows(u):
        product = jnp.einsum("mkc,kc->m", matrix, u)
        return product - target + (0.2 * jnp.sin(product) if bent else 0.0)

    def response(u):
        return rows(u), jnp.swapaxes(jax.jacrev(rows)(u), 0, 1)

    program = RootProgram(
        free=lambda args: free,
        importance=lambda args: jnp.ones(STAGES),
        row_weight=lambda args: row_weight,
        response=lambda u, args: response(u),
        limits=lambda args: jnp.asarray(LIMITS),
        effort_map=lambda args: jnp.eye(SIZE),
        effort_scale=lambda args: jnp.asarray(price),
        shared=False,
    )
    return solve(LeastEffort(SCHEDULE), program, u, None)


def run(matrix, target, u, free, row_weight, bent, price=1.0):
    return run_at(matrix, target, u, free, row_weight, bent, price)


def problems(seed, count, size):
    """Targets that controls of this size within limits reach; starts that miss them."""
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(count, ROWS, STAGES, SIZE))
    hidden = rng.uniform(-1.0, 1.0, (count, STAGES, SIZE))
    hidden *= size / np.abs(hidden @ LIMITS.T).max(axis=(1, 2), keepdims=True)
    free = np.ones_like(hidden)
    free[:, 1] = 0.0
    target = np.einsum("smkc,skc->sm", matrix, hidden * free)
    return matrix, target, hidden + 0.2 * rng.normal(size=hidden.shape), free


def linear_programme(matrix, target, free, price=1.0):
    """Least sum of magnitudes, each stage at its price, by SciPy: u = p - n with p, n >= 0."""
    columns = (matrix * free).reshape(ROWS, -1)
    faces = np.kron(np.eye(STAGES), LIMITS)
    return scipy.optimize.linprog(
        np.tile(np.repeat(np.broadcast_to(price, STAGES), SIZE), 2),
        A_ub=np.block([[faces, -faces], [-faces, faces]]),
        b_ub=np.ones(2 * len(faces)),
        A_eq=np.hstack([columns, -columns]),
        b_eq=target,
    )


@pytest.mark.parametrize("size", [0.5, 1.0, 1.6], ids=["loose", "tight", "often impossible"])
def test_linear_rows_give_what_linear_programming_gives(size):
    count = 24
    matrix, target, starts, free = problems(int(10 * size), count, size)
    found = run(matrix, target, starts, free, np.full((count, ROWS), np.inf), False)
    saturated = 0
    for k in range(count):
        best = linear_programme(matrix[k], target[k], free[k])
        if best.status == 0:
            assert found.status[k] == Status.CONVERGED
            np.testing.assert_allclose(np.abs(found.x[k]).sum(), best.fun, rtol=1e-4)
            np.testing.assert_allclose(np.einsum("mkc,kc->m", matrix[k], found.x[k]), target[k])
            saturated += int(np.abs(found.x[k] @ LIMITS.T).max() > 1.0 - 1e-5)
        else:
            assert found.status[k] in (Status.INFEASIBLE, Status.ITERATION_LIMIT)
    assert np.abs(found.x @ LIMITS.T).max() <= 1.0
    assert (found.x[:, 1] == 0.0).all()
    if size == 1.0:
        assert saturated > count / 3


def test_stages_whose_effort_costs_more_are_used_less():
    count, price = 8, np.geomspace(1.0, 30.0, STAGES)
    matrix, target, starts, free = problems(21, count, 0.5)
    found = run(matrix, target, starts, free, np.full((count, ROWS), np.inf), False, price)
    assert (found.status == Status.CONVERGED).all()
    for k in range(count):
        spent = price @ np.abs(found.x[k]).sum(axis=1)
        best = linear_programme(matrix[k], target[k], free[k], price)
        np.testing.assert_allclose(spent, best.fun, rtol=1e-3)
        np.testing.assert_allclose(found.objective[k], best.fun, rtol=1e-2)


def test_rows_that_bend_end_where_a_general_solver_ends():
    count = 8
    matrix, target, starts, free = problems(3, count, 0.9)
    bent = target + 0.2 * np.sin(target)
    found = run(matrix, bent, starts, free, np.full((count, ROWS), np.inf), True)
    assert (found.status == Status.CONVERGED).all()
    smoothing = SCHEDULE.smoothing_end
    for k in range(count):

        def rows(x, k=k):
            product = np.einsum("mkc,kc->m", matrix[k], x.reshape(STAGES, SIZE) * free[k])
            return product - bent[k] + 0.2 * np.sin(product)

        def effort(x):
            return np.sqrt(x**2 + smoothing**2).sum()

        constraints = [
            {"type": "eq", "fun": rows},
            {"type": "ineq", "fun": lambda x: (1.0 - x.reshape(STAGES, SIZE) @ LIMITS.T).ravel()},
            {"type": "ineq", "fun": lambda x: (1.0 + x.reshape(STAGES, SIZE) @ LIMITS.T).ravel()},
        ]
        near = found.x[k].ravel()
        assert np.abs(rows(near)).max() < 1e-8
        again = scipy.optimize.minimize(effort, near, method="SLSQP", constraints=constraints)
        assert effort(near) <= effort(again.x) + 1e-6


def test_multipliers_satisfy_the_conditions_for_a_minimum():
    matrix, target, starts, free = problems(5, 16, 1.0)
    found = run(matrix, target, starts, free, np.full((16, ROWS), np.inf), False)
    assert (found.status == Status.CONVERGED).all()
    faces = np.concatenate([LIMITS, -LIMITS])
    slope = found.x / np.sqrt(found.x**2 + SCHEDULE.smoothing_end**2)
    slope = slope + np.einsum("smkc,sm->skc", matrix, found.multipliers.equality)
    slope = slope + found.multipliers.stage @ faces
    scale = 1.0 + np.abs(found.multipliers.equality).max()
    assert np.abs(slope * free).max() < 1e-5 * scale
    assert found.multipliers.stage.min() >= 0.0
    assert np.abs(found.multipliers.stage * (1.0 - found.x @ faces.T)).max() < 1e-5


def test_soft_rows_are_a_compromise_at_the_minimum_of_the_sum():
    matrix, target, starts, free = problems(7, 6, 0.5)
    found = run(matrix, target, starts, free, np.full((6, ROWS), 0.3), False)
    assert (found.status == Status.CONVERGED).all()
    missed = np.einsum("smkc,skc->sm", matrix, np.asarray(found.x)) - target
    np.testing.assert_allclose(found.multipliers.equality, 0.3 * missed, atol=1e-5)
    assert np.abs(missed).max() > 1e-2


def test_a_start_of_nans_leaves_the_others_as_they_were():
    matrix, target, starts, free = problems(9, 6, 0.5)
    rows = np.full((6, ROWS), np.inf)
    clean = run(matrix, target, starts, free, rows, False)
    starts[2] = np.nan
    spoilt = run(matrix, target, starts, free, rows, False)
    assert spoilt.status[2] == Status.NOT_FINITE
    others = np.arange(6) != 2
    for a, b in zip(jax.tree.leaves(spoilt), jax.tree.leaves(clean), strict=True):
        np.testing.assert_array_equal(np.asarray(a)[others], np.asarray(b)[others])
