"""Smooth counts and efforts against what they stand for."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.problems.hands_off import sparsity

N, B = 12, 3


def random_torque(rng, share=0.4, scale=1.0):
    return scale * rng.normal(size=(N, B)) * (rng.random((N, 1)) < share)


@pytest.mark.parametrize("shared", [True, False])
def test_log_count_tends_to_the_weighted_count(shared):
    rng = np.random.default_rng(0)
    weight = rng.uniform(0.1, 2.0, N)
    u = random_torque(rng)
    active = np.abs(u) > 0
    count = (weight * (active.any(axis=1) if shared else active.sum(axis=1))).sum()
    errors = [
        abs(float(sparsity.log_count(jnp.asarray(u), jnp.asarray(weight), s, shared)) - count)
        for s in (1e-2, 1e-6, 1e-20, 1e-60)
    ]
    assert all(b < a for a, b in itertools.pairwise(errors))
    assert errors[-1] < 0.02 * count


@pytest.mark.parametrize("shared", [True, False])
def test_log_count_of_ones_and_zeros_is_exact(shared):
    u = np.zeros((N, B))
    u[[2, 7], 1] = [1.0, -1.0]
    found = sparsity.log_count(jnp.asarray(u), jnp.ones(N), 1e-3, shared)
    np.testing.assert_allclose(found, 2.0, rtol=1e-12)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("smoothing", [1.0, 0.1, 1e-3])
def test_curvature_majorises_the_log_count(shared, smoothing):
    rng = np.random.default_rng(1)
    weight = jnp.asarray(rng.uniform(0.1, 2.0, N))

    def count(u):
        return sparsity.log_count(u, weight, smoothing, shared)

    slope = jax.jit(jax.grad(count))
    for scale in (1e-3, 0.1, 3.0):
        u = jnp.asarray(random_torque(rng, 0.7, scale))
        base, gradient = count(u), slope(u)
        diagonal = sparsity.log_count_curvature(u, weight, smoothing, shared)
        for reach in (1e-4, 1e-2, 1.0, 10.0):
            d = jnp.asarray(reach * rng.normal(size=(N, B)))
            bound = base + jnp.vdot(gradient, d) + 0.5 * jnp.vdot(diagonal, d**2)
            assert float(count(u + d)) <= float(bound) + 1e-12
    # It is the tightest of its kind: u is a minimum of the bound along -u.
    np.testing.assert_allclose(diagonal * u, gradient, rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize("smoothing", [0.1, 1e-4])
def test_absolute_effort_and_its_curvature(smoothing):
    rng = np.random.default_rng(2)
    u = random_torque(rng)
    found = float(sparsity.absolute_effort(jnp.asarray(u), smoothing))
    assert 0.0 <= np.abs(u).sum() - found <= u.size * smoothing
    hessian = jnp.diagonal(
        jax.hessian(lambda x: sparsity.absolute_effort(x, smoothing))(jnp.asarray(u.ravel()))
    )
    curvature = np.asarray(sparsity.absolute_effort_curvature(jnp.asarray(u), smoothing)).ravel()
    assert (curvature >= np.asarray(hessian) * (1 - 1e-12)).all()
    assert (curvature <= 1.0 / np.sqrt(u.ravel() ** 2 + smoothing**2) * (1 + 1e-12)).all()


@pytest.mark.parametrize("shared", [True, False])
def test_complementarity_vector_is_feasible_and_the_best_of_a_grid(shared):
    rng = np.random.default_rng(3)
    epsilon = 1e-3
    torque = random_torque(rng) * 10.0 ** rng.uniform(-5, 1, (N, 1))
    torque[0] = [epsilon, -epsilon, 0.0]
    xi = np.asarray(sparsity.complementarity_vector(jnp.asarray(torque), epsilon, shared))
    assert xi.shape == ((N,) if shared else (N, B))
    product = np.abs(torque) * (xi[:, None] if shared else xi)
    assert product.max() <= epsilon * (1 + 1e-12)
    assert (xi > 0).all() and (xi <= 1).all()
    for trial in np.linspace(0.0, 1.0, 2001):
        size = np.abs(torque).max(axis=1) if shared else np.abs(torque)
        allowed = trial * size <= epsilon
        assert (xi[allowed] >= trial - 1e-12).all()
    assert (xi[0] == 1.0).all()


def test_complementarity_vector_over_batches_is_that_of_each():
    torque = np.random.default_rng(4).normal(size=(2, 5, N, B))
    together = sparsity.complementarity_vector(jnp.asarray(torque), 0.3)
    for i, j in np.ndindex(2, 5):
        alone = sparsity.complementarity_vector(jnp.asarray(torque[i, j]), 0.3)
        np.testing.assert_array_equal(together[i, j], alone)
