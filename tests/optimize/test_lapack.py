"""Decompositions are found wherever they stand in a function."""

import jax
import jax.numpy as jnp
import pytest

from jaxatt.optimize.lapack import calls_lapack

MATRIX = jnp.eye(2)


@pytest.mark.parametrize(
    ("function", "calls"),
    [
        (lambda m: m @ m + jnp.cross(jnp.ones(3), jnp.arange(3.0))[0], False),
        (jnp.linalg.inv, True),
        (jnp.linalg.det, False),
        (lambda m: jax.lax.fori_loop(0, 3, lambda i, x: jnp.linalg.solve(x, m), m), True),
        (lambda m: jax.lax.scan(lambda x, _: (x @ m, None), m, None, length=2)[0], False),
        (jax.jit(jax.grad(lambda m: jnp.sum(jnp.linalg.cholesky(m)))), True),
        (
            lambda m: jax.lax.cond(
                m[0, 0] > 0.0, lambda m: jnp.linalg.svd(m)[1], lambda m: m[0], m
            ),
            True,
        ),
    ],
)
def test_decompositions_are_found(function, calls):
    assert calls_lapack(function, MATRIX) is calls
