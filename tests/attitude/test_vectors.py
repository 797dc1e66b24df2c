import jax
import numpy as np
import pytest

from jaxatt.attitude import vectors


@pytest.mark.parametrize(("shape_a", "shape_b"), [((), ()), ((), (5,)), ((2, 1, 5), (4, 1))])
def test_products_broadcast_like_numpy(shape_a, shape_b):
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(*shape_a, 3)), rng.normal(size=(*shape_b, 3))
    np.testing.assert_allclose(jax.jit(vectors.cross)(a, b), np.cross(a, b), rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(
        jax.jit(vectors.dot)(a, b), np.sum(a * b, -1), rtol=1e-13, atol=1e-15
    )
    by_matrix = jax.jit(lambda a, b: vectors.matvec(vectors.skew(a), b))(a, b)
    np.testing.assert_allclose(by_matrix, np.cross(a, b), rtol=1e-13, atol=1e-15)


def test_norm_has_a_gradient_at_zero():
    v = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 4.0]])
    value, gradient = jax.vmap(jax.value_and_grad(vectors.norm))(v)
    np.testing.assert_allclose(value, [0.0, 5.0])
    np.testing.assert_allclose(gradient, [[0, 0, 0], [0.6, 0, 0.8]])


def test_floating_keeps_float32_and_lifts_integers():
    assert vectors.floating(np.float32([1.0])).dtype == np.float32
    assert vectors.floating([1, 2]).dtype == np.float64
