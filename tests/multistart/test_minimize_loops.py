"""The loop on the host and the compiled one take the same steps; the host compiles little."""

import gc
import weakref

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxatt
from jaxatt.optimize.dense import inputs
from jaxatt.optimize.dense.called import REMEMBERED, CalledFunctions
from jaxatt.optimize.dense.functions import Functions
from jaxatt.optimize.dense.trust_region import Spectrum, steps
from jaxatt.optimize.status import Status

PROBLEMS = 12


def objective(x, p):
    return x @ p["root"] @ x + p["slope"] @ x + p["wave"] * jnp.sum(jnp.sin(3.0 * x))


def equality(x, p):
    return p["row"] @ x - p["level"] * x[0] * x[1]


def inequality(x, p):
    return jnp.stack([p["size"] - x @ x, jnp.log(3.0 + x[0]) + x[1] ** 2 - p["least"]])


def random_problem(rng):
    """Two variables, three rows: curved both ways, now and then infeasible or unbounded."""
    return {
        "root": rng.normal(size=(2, 2)) + rng.uniform(0.0, 3.0) * np.eye(2),
        "slope": rng.normal(size=2),
        "wave": rng.choice([0.0, 1.0]),
        "row": rng.normal(size=2),
        "level": rng.choice([0.0, 1.0]),
        "size": rng.choice([-1.0, 1.0, 4.0, np.inf], p=[0.1, 0.4, 0.4, 0.1]),
        "least": rng.normal(),
    }


def both(x0, args, **options):
    rows = {"equality": equality, "inequality": inequality}
    return [
        jaxatt.minimize(objective, x0, (args,), loop=loop, **rows, **options)
        for loop in ("host", "compiled")
    ]


def test_both_loops_take_the_same_steps():
    rng = np.random.default_rng(1971)
    seen, passes = set(), []
    for _ in range(PROBLEMS):
        args, x0 = random_problem(rng), rng.normal(size=2)
        lower = np.where(rng.uniform(size=2) < 0.5, -1.0, -np.inf)
        here, there = both(x0, args, lower=lower, upper=np.array([2.0, np.inf]))
        assert here.status is there.status
        seen.add(here.status)
        if here.status is not Status.CONVERGED:
            continue
        passes.append((here.iterations, there.iterations))
        np.testing.assert_allclose(here.x, there.x, atol=1e-6)
        np.testing.assert_allclose(
            here.multipliers.inequality, there.multipliers.inequality, atol=1e-5
        )
    assert Status.CONVERGED in seen and len(seen) > 1
    same = np.array([one == other for one, other in passes])
    assert len(same) > PROBLEMS // 2 and same.mean() > 0.8  # a tie may fall either way


def test_the_host_compiles_the_functions_alone_and_each_once(compilations):
    def valley(x, a):
        return (x[0] - a) ** 2 + 7.0 * (x[1] - x[0] ** 2) ** 2

    jaxatt.minimize(lambda x: x @ x, [1.0, 1.0])
    before = len(compilations)
    found = jaxatt.minimize(valley, [-1.0, 2.0], (1.0,))
    assert found.status is Status.CONVERGED
    names = compilations[before:]
    assert 0 < len(names) <= 3, names
    found = jaxatt.minimize(valley, [3.0, 0.5], (2.0,), lower=-4.0, tolerance=1e-8)
    np.testing.assert_allclose(found.x, [2.0, 4.0], atol=1e-6)
    assert compilations[before:] == names


def test_many_starts_of_a_problem_are_compiled():
    def where(starts):
        return inputs.loop_of("auto", "newton", "a problem of this test", starts)

    assert where(17) == "compiled" and where(1) == "host"
    assert inputs.loop_of("auto", "lbfgs", "another", 1) == "compiled"
    count = 1
    while where(15) == "host":
        count += 15
    assert count >= 256 and where(1) == "compiled"


def test_functions_of_problems_long_ago_are_let_go():
    def bowl():
        return lambda x: x @ x

    def meet(functions):
        problem = inputs.problem_of(functions, np.zeros(2), ())
        inputs.loop_of("auto", "newton", problem, 1)
        inputs.counts_of(functions, np.zeros(2), (), problem)
        CalledFunctions(functions, 0, 0)

    first = bowl()
    assert jaxatt.minimize(first, [1.0, 2.0]).status is Status.CONVERGED
    held = weakref.ref(first)
    del first
    gc.collect()
    assert held() is not None
    for _ in range(REMEMBERED):
        meet(Functions(bowl()))
    gc.collect()
    assert held() is None


@pytest.mark.parametrize("options", [{"loop": "device"}, {"loop": "host", "inner": "adam"}])
def test_loops_that_do_not_exist_are_refused(options):
    with pytest.raises(ValueError, match=r"loop = .*choose"):
        jaxatt.minimize(lambda x: x @ x, [1.0, 1.0], **options)


compiled_steps = jax.jit(steps)


@pytest.mark.parametrize("seed", range(20))
def test_steps_within_a_radius_are_minimisers_of_the_model(seed):
    rng, n = np.random.default_rng(seed), 4
    values = np.sort(rng.normal(size=n) * 10.0 ** rng.uniform(-3, 3, n))
    vectors, _ = np.linalg.qr(rng.normal(size=(n, n)))
    gradient = rng.normal(size=n) * 10.0 ** rng.uniform(-4, 4)
    radii = 10.0 ** rng.uniform(-6, 3, 4)
    with np.errstate(all="ignore"):
        found = steps(gradient, Spectrum(values, vectors), radii)
    hessian = vectors @ np.diag(values) @ vectors.T

    def model(p):
        return p @ gradient + 0.5 * np.sum(p * (p @ hessian), axis=-1)

    for step, radius in zip(found, radii, strict=True):
        assert np.linalg.norm(step) <= radius * (1.0 + 1e-6)
        others = rng.normal(size=(200, n))
        others *= radius * rng.uniform(size=(200, 1)) / np.linalg.norm(others, axis=1)[:, None]
        others = np.concatenate([others, step + 1e-3 * others])
        inside = others[np.linalg.norm(others, axis=1) <= radius]
        assert model(step) <= model(inside).min() + 1e-9 * abs(model(step))
    spectrum = Spectrum(jnp.asarray(values), jnp.asarray(vectors))
    again = compiled_steps(jnp.asarray(gradient), spectrum, jnp.asarray(radii))
    np.testing.assert_allclose(again, found, rtol=1e-6, atol=1e-9 * np.abs(found).max())
