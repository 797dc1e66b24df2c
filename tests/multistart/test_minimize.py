"""The general entry on single problems: statuses, inputs, batches, recompilation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxatt
from jaxatt.optimize.dense.constraints import Box
from jaxatt.optimize.dense.inputs import seed_of
from jaxatt.optimize.dense.start import draw
from jaxatt.optimize.status import Status


def bowl(x, centre):
    return jnp.sum((x - centre) ** 2)


def circle(x, centre):
    return jnp.sum(x**2) - 1.0


def right_half(x, centre):
    return x[0]


CENTRE = (jnp.array([2.0, 1.0]),)
NEAREST = np.array([2.0, 1.0]) / np.sqrt(5.0)


def solve(x0=(0.3, -0.4), args=CENTRE, **options):
    return jaxatt.minimize(bowl, x0, args, equality=circle, inequality=right_half, **options)


def test_a_constrained_minimum_and_its_multipliers():
    found = solve()
    assert found.status is Status.CONVERGED
    np.testing.assert_allclose(found.x, NEAREST, atol=1e-9)
    np.testing.assert_allclose(found.objective, (np.sqrt(5.0) - 1.0) ** 2, rtol=1e-9)
    # 2 (x - c) + y 2 x = 0
    np.testing.assert_allclose(found.multipliers.equality, [np.sqrt(5.0) - 1.0], rtol=1e-8)
    np.testing.assert_allclose(found.multipliers.inequality, [0.0])
    assert found.max_violation < 1e-9 and found.stationarity < 1e-9
    assert "CONVERGED" in repr(found) and "objective" in repr(found)


@pytest.mark.parametrize("inner", ["gauss-newton", "lbfgs", "adam"])
def test_other_inner_minimisers_find_the_same(inner):
    found = solve(inner=inner, tolerance=1e-5)
    assert found.status is Status.CONVERGED
    np.testing.assert_allclose(found.x, NEAREST, atol=1e-4)


def test_new_args_starts_and_bounds_do_not_trace_again():
    traced = []

    def objective(x, a):
        traced.append(1)
        return jnp.sum((x - a) ** 4)

    jaxatt.minimize(objective, [0.0, 0.0], (1.0,), lower=-1.0)
    count = len(traced)
    found = jaxatt.minimize(objective, [3.0, 0.5], (2.0,), lower=-3.0, upper=[1.0, 5.0])
    assert len(traced) == count
    np.testing.assert_allclose(found.x, [1.0, 2.0], atol=1e-2)


def test_a_start_that_is_not_finite_leaves_the_others_alone():
    starts = np.random.default_rng(0).normal(size=(4, 2))
    clean = solve(starts)
    spoilt = starts.copy()
    spoilt[2] = np.nan
    found = solve(spoilt)
    others = [0, 1, 3]
    assert found.starts.status[2] == Status.NOT_FINITE
    np.testing.assert_array_equal(found.starts.x[others], clean.starts.x[others])
    np.testing.assert_array_equal(found.starts.objective[others], clean.starts.objective[others])
    assert found.status is Status.CONVERGED


def test_nothing_finite_is_said_so():
    found = solve(args=(jnp.array([jnp.nan, 1.0]),))
    assert found.status is Status.NOT_FINITE


def test_the_functions_never_see_points_outside_the_bounds():
    lower, upper = np.array([0.1, -2.0, 3.0]), np.array([0.7, -1.1, 3.0])
    seen = []

    def objective(x):
        jax.debug.callback(lambda value: seen.append(np.array(value)), x)
        return jnp.sum((x - 1.0) ** 2) + jnp.sin(7.0 * x[0] * x[1])

    found = jaxatt.minimize(objective, [5.0, 5.0, 5.0], lower=lower, upper=upper)
    assert found.status is Status.CONVERGED
    assert found.x[2] == 3.0
    points = np.concatenate([np.atleast_2d(value) for value in seen])
    assert (points >= lower).all() and (points <= upper).all()


def test_draws_depend_on_key_and_index_alone():
    def wave(x):
        return jnp.sum(jnp.sin(3.0 * x) + 0.05 * x**2)

    found = jaxatt.minimize(wave, [1.0, 4.0], starts=5)
    again = jaxatt.minimize(wave, [1.0, 4.0], starts=5, key=jax.random.key(0))
    other = jaxatt.minimize(wave, [1.0, 4.0], starts=5, key=jax.random.key(1))
    np.testing.assert_array_equal(again.starts.x, found.starts.x)
    np.testing.assert_array_equal(other.starts.x[0], found.starts.x[0])
    assert (np.abs(other.starts.x - found.starts.x).max(axis=1) > 1e-3).any()
    assert found.objective == found.starts.objective.min()
    own, seed = np.array([[1.0, 4.0]]), seed_of(jax.random.key(0))
    box = Box(np.array([-np.inf, -1.0]), np.array([np.inf, 5.0]))
    few, more = (draw(own, np.arange(count), box, seed).x0 for count in (3, 5))
    np.testing.assert_array_equal(few, more[:3])
    np.testing.assert_array_equal(few[0], own[0])
    assert len(np.unique(more[:, 0])) == 5


def quadratic(x):
    return jnp.sum(x**2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"x0": np.zeros((2, 2, 2))}, "x0 has shape"),
        ({"x0": []}, "x0 has shape"),
        ({"x0": "one"}, "must be a vector"),
        ({"starts": 0}, "starts = 0"),
        ({"x0": np.zeros((3, 2)), "starts": 2}, "x0 holds 3 starts"),
        ({"lower": [1.0, 0.0], "upper": 0.5}, r"lower\[0\] = 1 is above upper\[0\] = 0.5"),
        ({"lower": [1.0, 0.0, 0.0]}, "lower has shape"),
        ({"upper": np.nan}, "holds nan"),
        ({"inner": "simplex"}, "choose one of auto, newton"),
        ({"key": 3}, "jax.random.key"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"max_iterations": 0}, "max_iterations"),
        ({"equality": lambda x: jnp.outer(x, x)}, "equality returns an array of shape"),
        ({"objective": lambda x: x}, "objective returns an array of shape"),
        ({"inequality": 3.0}, "must be a function"),
    ],
)
def test_bad_input_is_named(options, message):
    given = {"objective": quadratic, "x0": [0.0, 0.0], **options}
    with pytest.raises(ValueError, match=message):
        jaxatt.minimize(given.pop("objective"), given.pop("x0"), **given)


def test_single_precision_is_refused():
    with jax.enable_x64(False), pytest.raises(ValueError, match="jax_enable_x64 is off"):
        jaxatt.minimize(quadratic, [0.0, 0.0])
