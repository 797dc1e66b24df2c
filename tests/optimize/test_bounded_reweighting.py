"""The quadratic programme between bounds against an independent solver; roots of linear rows."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import lsq_linear

from jaxatt.optimize.reweighting.bounded import BoundedReweighting, bounded_step
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.solver import solve


@pytest.mark.parametrize("seed", range(6))
def test_step_agrees_with_bounded_least_squares(seed: int) -> None:
    rng = np.random.default_rng(seed)
    jacobian, target = rng.normal(size=(4, 15)), 3.0 * rng.normal(size=4)
    lower, upper = np.where(rng.uniform(size=15) < 0.5, 0.0, -1.0), np.ones(15)
    d, slack = rng.uniform(0.1, 3.0, 15), rng.uniform(0.01, 0.1, 4)
    v, _ = bounded_step(
        *(jnp.asarray(part) for part in (jacobian, target, d, lower, upper, slack)),
        jnp.zeros(4),
        60,
    )
    stacked = np.concatenate([jacobian / np.sqrt(slack)[:, None], np.diag(1.0 / np.sqrt(d))])
    wanted = lsq_linear(
        stacked, np.concatenate([target / np.sqrt(slack), np.zeros(15)]), (lower, upper), tol=1e-14
    )
    np.testing.assert_allclose(v, wanted.x, atol=1e-5)


@pytest.mark.parametrize("kind", ["feasible", "out of reach", "not a number"])
def test_bounds_hold_whatever_the_rows(kind: str) -> None:
    rng = np.random.default_rng(3)
    weights = jnp.asarray(rng.normal(size=(3, 10, 2)))
    size = {"feasible": 0.3, "out of reach": 1e3, "not a number": np.nan}[kind]
    inside = jnp.asarray(rng.uniform(0.0, 1.0, (10, 2)))
    wanted = jnp.einsum("ikc,kc->i", weights, inside) * size / 0.3

    program = RootProgram(
        free=lambda args: jnp.ones((10, 2)),
        importance=lambda args: jnp.ones(10),
        row_weight=lambda args: jnp.full(3, jnp.inf),
        response=lambda u, args: (
            jnp.einsum("ikc,kc->i", weights, u) - wanted,
            jnp.swapaxes(weights, 0, 1),
        ),
        bounds=lambda args: (jnp.zeros((10, 2)), jnp.ones((10, 2))),
    )
    start = jnp.asarray(rng.uniform(size=(4, 10, 2)))
    found = jax.vmap(lambda u: solve(BoundedReweighting(), program, u, None))(start)
    known = np.nan_to_num(np.asarray(found.u))
    assert (known >= 0.0).all() and (known <= 1.0).all()
    if kind == "feasible":
        assert (np.asarray(found.residual) < 1e-8).all()
        assert ((known > 1e-6).any(axis=2).sum(axis=1) < 10).all()
    else:
        assert not (np.asarray(found.residual) < 1e-3).any()
