"""The Riccati step against the algebraic Riccati equation and dense systems."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from jaxatt.attitude.state_manifold import difference, retract
from jaxatt.optimize.optimal_control import OptimalControlProgram, fly, least_squares
from jaxatt.optimize.riccati.recursion import (
    StageModel,
    Trajectory,
    backward_step,
    derivatives_along,
    fly_with_feedback,
)


def system(rng, n, b):
    a = rng.normal(size=(n, n))
    return a / np.abs(np.linalg.eigvals(a)).max() * 1.05, rng.normal(size=(n, b))


recursion = jax.jit(backward_step)


@jax.jit
def step(matrix, weight, value):
    n = len(value)
    b = len(weight) - n
    model = StageModel(matrix, weight, jnp.zeros(n + b))

    def once(_, carry):
        found, law, _, _ = backward_step(carry[0], model, jnp.ones(b), jnp.zeros(b), jnp.zeros(()))
        return found, law

    return jax.lax.fori_loop(0, 400, once, (value, jnp.zeros((b, n + 1))))


@pytest.mark.parametrize("seed", range(3))
def test_recursion_tends_to_the_algebraic_riccati_equation(seed):
    rng = np.random.default_rng(seed)
    n, b = 4, 2
    a, g = system(rng, n, b)
    q, r = np.diag(rng.uniform(0.5, 2.0, n)), np.diag(rng.uniform(0.5, 2.0, b))
    matrix = np.concatenate([a, g], axis=1)

    value, law = step(matrix, scipy.linalg.block_diag(q, r), jnp.zeros((n, n + 1)))
    exact = scipy.linalg.solve_discrete_are(a, g, q, r)
    np.testing.assert_allclose(np.asarray(value)[:, :n], exact, rtol=1e-8, atol=1e-9)
    gain = -np.linalg.solve(r + g.T @ exact @ g, g.T @ exact @ a)
    np.testing.assert_allclose(law[:, :n], gain, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("held", [False, True])
def test_step_solves_the_dense_system(held):
    rng = np.random.default_rng(5)
    n, b, stages = 3, 2, 6
    size = n + b
    blocks = rng.normal(size=(stages, size, size))
    blocks = blocks @ blocks.swapaxes(1, 2) + 0.1 * np.eye(size)
    gradients = rng.normal(size=(stages, size))
    matrices = np.stack([np.concatenate(system(rng, n, b), axis=1) for _ in range(stages)])
    free = (rng.random((stages, b)) > 0.4).astype(float) if held else np.ones((stages, b))
    forced = (1.0 - free) * rng.normal(size=(stages, b))
    end = np.eye(n) * 3.0
    pull = rng.normal(size=n)

    value = jnp.asarray(np.concatenate([end, pull[:, None]], axis=1))
    laws, slope = [], 0.0
    for k in reversed(range(stages)):
        model = StageModel(*(jnp.asarray(m[k]) for m in (matrices, blocks, gradients)))
        value, law, part, _ = recursion(
            value, model, jnp.asarray(free[k]), jnp.asarray(forced[k]), jnp.zeros(())
        )
        laws.insert(0, np.asarray(law))
        slope += float(part)
    e, found = np.zeros(n), []
    for k in range(stages):
        u = laws[k][:, :n] @ e + laws[k][:, n]
        found.append(u)
        e = matrices[k] @ np.concatenate([e, u])

    # The same in all controls at once: z_k = maps[k] u.
    maps, to_state = [], np.zeros((n, stages * b))
    for k in range(stages):
        pick = np.zeros((b, stages * b))
        pick[:, k * b : (k + 1) * b] = np.eye(b)
        maps.append(np.concatenate([to_state, pick]))
        to_state = matrices[k] @ maps[k]
    hessian = sum(m.T @ block @ m for m, block in zip(maps, blocks, strict=True))
    hessian = hessian + to_state.T @ end @ to_state
    gradient = sum(m.T @ g for m, g in zip(maps, gradients, strict=True)) + to_state.T @ pull
    moves = free.ravel() > 0
    u = forced.ravel().copy()
    rhs = -(gradient + hessian @ u)[moves]
    u[moves] = np.linalg.solve(hessian[np.ix_(moves, moves)], rhs)
    np.testing.assert_allclose(np.concatenate(found), u, rtol=1e-8, atol=1e-9)
    if not held:
        np.testing.assert_allclose(slope, gradient @ u, rtol=1e-8)


def test_whole_step_solves_a_linear_quadratic_problem_at_once():
    rng = np.random.default_rng(2)
    n, b, stages = 3, 1, 12
    a, g = system(rng, n, b)
    cost, curvature = least_squares(lambda x, u, k, p: jnp.concatenate([x, u]), n)
    program = OptimalControlProgram(
        start=lambda p: jnp.ones(n),
        stages=lambda p: jnp.zeros(stages),
        dynamics=lambda x, u, k, p: jnp.asarray(a) @ x + jnp.asarray(g) @ u,
        cost=cost,
        curvature=curvature,
        error_size=n,
    )
    x, end = fly(program, jnp.zeros((stages, b)), None)
    flown = Trajectory(x, end, jnp.zeros((stages, b)))
    matrices = jax.jit(lambda flown: derivatives_along(program, flown, None))(flown)
    np.testing.assert_allclose(matrices[3], np.concatenate([a, g], axis=1), atol=1e-12)
    value, laws = jnp.zeros((n, n + 1)), []
    for k in reversed(range(stages)):
        z = jnp.concatenate([x[k], flown.u[k]])
        model = StageModel(matrices[k], jnp.eye(n + b), z)
        value, law, _, _ = recursion(value, model, jnp.ones(b), jnp.zeros(b), jnp.zeros(()))
        laws.insert(0, law)
    better, _ = fly_with_feedback(program, flown, jnp.stack(laws), jnp.ones(()), None)

    def total(u):
        x, _ = fly(program, u, None)
        return 0.5 * jnp.sum(x**2) + 0.5 * jnp.sum(u**2)

    assert float(jnp.abs(jax.jit(jax.grad(total))(better.u)).max()) < 1e-9


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, np.pi, 5.0])
def test_error_coordinates_of_an_attitude_return_what_they_were_given(angle):
    rng = np.random.default_rng(0)
    x = rng.normal(size=7)
    x[:4] /= np.linalg.norm(x[:4])
    axis = rng.normal(size=3)
    error = rng.normal(size=6)
    error[:3] = 4.0 * np.tan(angle / 4.0) * axis / np.linalg.norm(axis)
    moved = retract(jnp.asarray(x), jnp.asarray(error))
    assert float(jnp.linalg.norm(moved[:4])) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(difference(moved, jnp.asarray(x)), error, rtol=1e-9, atol=1e-14)
