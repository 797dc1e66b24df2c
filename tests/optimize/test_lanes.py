"""Functions in lanes give under any `jax.vmap` what they give one by one."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.optimize.lanes import computed_once, each_lane, in_lanes


def _one(x, shared, stage):
    """A loop over rows, with a matrix for every lane."""
    return jnp.cumsum(jnp.sin(stage * x) * shared[0]), jnp.outer(x, shared)


@in_lanes
def _laned(x, shared, stage):
    assert x.ndim == 2 and shared.ndim == 2 and stage.ndim == 1
    total = jnp.cumsum(jnp.sin(stage[None] * x) * shared[:1], axis=0)
    return total, each_lane(jnp.outer)(x, shared)


def _inputs(*batch):
    rng = np.random.default_rng(len(batch))
    return rng.normal(size=(*batch, 4)), rng.normal(size=3), rng.normal(size=batch[-1:])


def _same(found, expected):
    jax.tree.map(lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-14), found, expected)


def test_without_a_batch():
    x, shared, _ = _inputs(1)
    _same(_laned(x[0], shared, jnp.asarray(0.3)), _one(x[0], shared, 0.3))


@pytest.mark.parametrize("axes", [(0, None, 0), (0, None, None)])
def test_under_one_batch(axes):
    x, shared, stage = _inputs(5)
    stage = stage if axes[2] == 0 else stage[0]
    _same(*(jax.vmap(f, in_axes=axes)(x, shared, stage) for f in (_laned, _one)))


@pytest.mark.parametrize("shared_axis", [None, 0])
def test_stages_within_starts_are_one_axis(shared_axis):
    # Stages (5) within starts (7): their own data, those of a stage, those of a start or of all.
    x, shared, stage = _inputs(7, 5)
    shared = shared if shared_axis is None else np.random.default_rng(3).normal(size=(7, 3))

    def along(f):
        return jax.vmap(jax.vmap(f, in_axes=(0, None, 0)), in_axes=(0, shared_axis, None))

    _same(*(jax.jit(along(f))(x, shared, stage) for f in (_laned, _one)))


def test_results_that_are_the_same_for_all_lanes_are_given_to_each():
    found = jax.vmap(in_lanes(lambda x, y: (x + y, 2.0 * y)), in_axes=(0, None))(
        jnp.arange(3.0), jnp.asarray(1.0)
    )
    _same(found, (np.array([1.0, 2.0, 3.0]), np.full(3, 2.0)))


def test_computed_once_is_what_the_function_gives():
    def point(total, index):
        return total + computed_once(jnp.cos, index >= 0)(total), None

    def plain(total, index):
        return total + jnp.cos(total), None

    begin = jnp.asarray(np.random.default_rng(4).normal(size=3))
    _same(*(jax.lax.scan(f, begin, jnp.arange(4))[0] for f in (point, plain)))
