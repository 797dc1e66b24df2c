"""Derivatives at the places where the textbook formulas divide by zero."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.attitude import errors, euler, mrp, quaternion

REFERENCE = np.array([1.0, 0.0, 0.0, 0.0])


def measures(q):
    every = (errors.angle, errors.pseudo_metric, errors.smooth_pseudo_metric)
    return jnp.stack([measure(REFERENCE.astype(q.dtype), q) for measure in every], axis=-1)


OF_A_QUATERNION = {
    "normalize": quaternion.normalize,
    "to_rotation_vector": quaternion.to_rotation_vector,
    "from_matrix": lambda q: quaternion.from_matrix(quaternion.to_matrix(q)),
    "slerp": lambda q: quaternion.slerp(REFERENCE.astype(q.dtype), q, jnp.asarray(0.3, q.dtype)),
    "mrp": mrp.from_quaternion,
    "mrp_signed": lambda q: mrp.from_quaternion(q, short=False),
    "mrp_switch": lambda q: mrp.switch(mrp.shadow(mrp.from_quaternion(q))),
    "euler": euler.from_quaternion,
    "measures": measures,
}


BATCH = 1600


@functools.cache
def compiled(name):
    """Value, forward and reverse Jacobian over a batch; compiled once for each precision."""
    function = OF_A_QUATERNION[name]

    def all_three(q):
        return function(q), jax.jacfwd(function)(q), jax.jacrev(function)(q)

    return jax.jit(jax.vmap(all_three))


def evaluate(name, q):
    padded = np.resize(q, (BATCH, 4)).astype(q.dtype)
    return [np.asarray(x)[: len(q)] for x in compiled(name)(padded)]


@pytest.mark.parametrize(
    ("name", "dtype"),
    [(name, np.float64) for name in OF_A_QUATERNION]
    + [(name, np.float32) for name in ("to_rotation_vector", "mrp_signed", "euler", "measures")],
)
def test_derivatives_are_finite_at_every_attitude(name, dtype, attitudes):
    half = np.sqrt(0.5)
    gimbal_lock = [[half, 0, half, 0], [half, 0, -half, 0], [0.5, 0.5, 0.5, -0.5]]
    q = np.concatenate([attitudes, gimbal_lock, [[1, 0, 0, 0], [-1, 0, 0, 0]]])
    if name in ("mrp_signed", "mrp_switch"):
        # The shadow of the identity lies at infinity: derivatives overflow on the way there.
        far = np.linalg.norm(q[:, 1:], axis=1)
        q = q[(far == 0) | (far > 1e-6)]
    assert len(q) <= BATCH
    q = q.astype(dtype)
    value, forward, reverse = evaluate(name, q)
    assert value.dtype == forward.dtype == reverse.dtype == dtype
    for result in (value, forward, reverse):
        bad = ~np.isfinite(result.reshape(len(q), -1)).all(axis=1)
        assert not bad.any(), q[bad]
    scale = np.max(np.abs(forward), axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(
        (forward - reverse) / np.maximum(scale, 1), 0.0, atol=50 * np.finfo(dtype).eps
    )


@pytest.mark.parametrize("name", OF_A_QUATERNION)
def test_derivatives_match_finite_differences(name):
    # Away from eta = 0, where measures that ignore the sign have their kink.
    q = np.array([[0.8, 0.3, -0.4, 0.2], [-0.5, 0.5, 0.1, 0.7], [0.99, 0.02, -0.05, 0.01]])
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    step = 1e-6 * np.eye(4)
    ahead, _, _ = evaluate(name, (q[:, None] + step).reshape(-1, 4))
    behind, _, _ = evaluate(name, (q[:, None] - step).reshape(-1, 4))
    difference = np.swapaxes((ahead - behind).reshape(3, 4, -1), 1, 2) / 2e-6
    np.testing.assert_allclose(evaluate(name, q)[1], difference, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("name", OF_A_QUATERNION)
def test_not_a_number_is_not_hidden(name):
    """A guard must not turn a state that blew up into a healthy attitude."""
    q = np.full((5, 4), 0.5)
    q[np.arange(4), np.arange(4)] = np.nan
    q[4] = np.nan
    assert np.isnan(evaluate(name, q)[0]).any(axis=1).all()


def test_exponential_is_smooth_at_zero_to_second_order():
    zero = np.zeros(3)
    jacobian = jax.jit(jax.jacrev(quaternion.from_rotation_vector))(zero)
    np.testing.assert_allclose(jacobian, np.vstack([np.zeros(3), 0.5 * np.eye(3)]), atol=1e-16)
    hessian = jax.jit(jax.hessian(quaternion.from_rotation_vector))(zero)
    np.testing.assert_allclose(hessian[0], -0.25 * np.eye(3), atol=1e-16)
    np.testing.assert_allclose(hessian[1:], 0.0, atol=1e-16)


def test_exponential_and_logarithm_are_smooth_across_the_switch_to_series():
    """Second derivatives on either side of the switch agree, along a fixed axis."""
    axis = np.array([0.6, 0.0, 0.8])

    def eps(angle):
        return quaternion.from_rotation_vector(angle * axis)[1]

    def length(half):
        q = jnp.concatenate([jnp.cos(half)[None], jnp.sin(half) * axis])
        return quaternion.to_rotation_vector(q)[0]

    def derivatives(f, x):
        first = jax.jacfwd(f)
        return jax.jit(jax.vmap(lambda x: jnp.stack([first(x), jax.jacfwd(first)(x)])))(x).T

    angle = np.array([0.0999, 0.1001])
    expected = 0.6 * np.stack([np.cos(angle / 2) / 2, -np.sin(angle / 2) / 4])
    np.testing.assert_allclose(derivatives(eps, angle), expected, rtol=1e-9)
    half = np.arctan(np.sqrt(1e-3)) * np.array([0.999, 1.001])
    expected = np.array([[1.2, 1.2], [0, 0]])
    np.testing.assert_allclose(derivatives(length, half), expected, atol=1e-10)
