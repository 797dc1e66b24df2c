"""The Gauss-Newton step against a dense solve of the Hessian that its docstring states."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.optimize.augmented_lagrangian.gauss_newton import LocalModel, gauss_newton


def problem(rng, stages, size, rows, held):
    factors = rng.normal(size=(stages, size, size))
    blocks = factors @ factors.swapaxes(1, 2) + 0.1 * np.eye(size)
    free = np.ones((stages, size))
    if held:
        free[rng.random((stages, size)) < 0.4] = 0.0
    return LocalModel(
        jnp.asarray(blocks),
        jnp.asarray(rng.normal(size=(rows, stages, size))),
        jnp.asarray(rng.uniform(0.0, 1e3, rows) * (rng.random(rows) < 0.8)),
        jnp.asarray(free),
    )


def dense(model):
    """diag(B_1 .. B_N) + J' diag(w) J as one matrix."""
    stages, size = model.free.shape
    n = stages * size
    hessian = np.zeros((n, n))
    for k in range(stages):
        hessian[k * size : (k + 1) * size, k * size : (k + 1) * size] = model.blocks[k]
    rows = np.asarray(model.rows).reshape(-1, n)
    return hessian + rows.T @ np.diag(np.asarray(model.weights)) @ rows


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize(
    ("stages", "size", "rows"),
    [(7, 3, 6), (5, 1, 2), (6, 4, 0), (4, 3, 9), (3, 10, 4)],
    ids=["low rank", "scalar stages", "no rows", "many rows", "big stages"],
)
def test_step_solves_the_documented_system(stages, size, rows, held):
    rng = np.random.default_rng(stages * 100 + rows + held)
    model = problem(rng, stages, size, rows, held)
    gradient = jnp.asarray(rng.normal(size=(stages, size)))
    hessian = dense(model)
    moves = np.flatnonzero(np.asarray(model.free).ravel())
    expected = np.zeros(stages * size)
    expected[moves] = -np.linalg.solve(
        hessian[np.ix_(moves, moves)], np.asarray(gradient).ravel()[moves]
    )
    minimiser = gauss_newton(damping=1e-12)
    x = jnp.asarray(rng.normal(size=(stages, size)))

    def value(y):
        d = (y - x).ravel()
        return jnp.vdot(gradient, y - x) + 0.5 * d @ jnp.asarray(hessian) @ d

    @jax.jit
    def step(x):
        state = minimiser.init(x)
        return minimiser.update(
            gradient, state, x, model=model, value=value(x), grad=gradient, value_fn=value
        )[0]

    found = np.asarray(step(x))
    np.testing.assert_allclose(
        found.ravel(), expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max()
    )
    assert not found[np.asarray(model.free) == 0].any()


def test_the_line_search_shortens_a_step_that_would_go_up():
    # The model knows a tenth of the curvature: the full step overshoots by a factor of ten.
    x = jnp.ones((2, 1))
    model = LocalModel(
        jnp.full((2, 1, 1), 0.1), jnp.zeros((0, 2, 1)), jnp.zeros(0), jnp.ones_like(x)
    )
    minimiser = gauss_newton()

    def value(y):
        return 0.5 * jnp.sum(y**2)

    step, _ = minimiser.update(
        x, minimiser.init(x), x, model=model, value=value(x), grad=x, value_fn=value
    )
    assert float(value(x - 10.0 * x)) > float(value(x))
    assert float(value(x + step)) < float(value(x))
    assert (np.asarray(step) < 0).all()
