"""Sensitivities of answers of `minimize`: against re-solving, and every degeneracy is flagged."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxatt
from jaxatt.optimize.sensitivity.regularity import Degeneracy
from jaxatt.optimize.status import Status

N, STEP = 4, 1e-4


def objective(x, p):
    bent = jnp.sum(jnp.cosh(p["stretch"] * (x - p["centre"])))
    return bent + 0.5 * x @ p["matrix"] @ x


def equality(x, p):
    return p["normal"] @ x + 0.1 * x[0] * x[1] - p["level"]


def inequality(x, p):
    return jnp.stack([p["radius"] - jnp.sum(x**2), x[2] - p["floor"] + 0.05 * x[3] ** 2])


def problem(seed):
    """Random parameters of a convex-looking problem of which some limits hold."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(N, N))
    return {
        "stretch": jnp.asarray(rng.uniform(0.5, 1.2)),
        "centre": jnp.asarray(rng.normal(size=N)),
        "matrix": jnp.asarray(root @ root.T / N),
        "normal": jnp.asarray(rng.normal(size=N)),
        "level": jnp.asarray(rng.normal(scale=0.3)),
        "radius": jnp.asarray(rng.uniform(0.5, 2.0)),
        "floor": jnp.asarray(rng.uniform(-0.5, 0.5)),
    }


BOUNDS = {"lower": -1.0, "upper": 0.6}


def solved(p, x0=None):
    return jaxatt.minimize(
        objective,
        np.zeros(N) if x0 is None else x0,
        (p,),
        equality=equality,
        inequality=inequality,
        tolerance=1e-11,
        **BOUNDS,
    )


def optimum_of(p):
    found = solved(p)
    return jaxatt.differentiable_minimum(
        found, objective, (p,), equality=equality, inequality=inequality, **BOUNDS
    )


def test_derivatives_are_those_of_solving_again():
    compared = held = 0
    for seed in range(12):
        p = problem(seed)
        if solved(p).status != Status.CONVERGED:
            continue
        optimum = optimum_of(p)
        if optimum.flags or compared == 4:
            continue
        compared += 1
        rng = np.random.default_rng(seed)
        way = jax.tree.map(lambda leaf, r=rng: jnp.asarray(r.normal(size=leaf.shape)), p)
        value, slope = jax.jvp(lambda q, o=optimum: o(q)[0], (p,), (way,))
        _, moved = jax.jvp(lambda q, o=optimum: o(q)[1]["x"], (p,), (way,))
        ends = [
            solved(
                jax.tree.map(lambda a, b, t=t: a + t * STEP * b, p, way),
                np.asarray(optimum(p)[1]["x"]),
            )
            for t in (2, 1, -1, -2)
        ]
        costs, points = [e.objective for e in ends], [e.x for e in ends]

        def difference(v):
            return (8 * (v[1] - v[2]) - (v[0] - v[3])) / (12 * STEP)

        np.testing.assert_allclose(slope, difference(costs), rtol=1e-5, atol=1e-7)
        scale = np.abs(difference(points)).max()
        np.testing.assert_allclose(moved, difference(points), rtol=1e-5, atol=1e-5 * scale)
        held += int(np.any(optimum.answer.holding.active))
        gradient = jax.grad(lambda q, o=optimum: o(q)[0])(p)
        inner = sum(
            jnp.vdot(a, b) for a, b in zip(*map(jax.tree.leaves, (gradient, way)), strict=True)
        )
        np.testing.assert_allclose(inner, slope, rtol=1e-9)
        np.testing.assert_allclose(value, solved(p).objective, rtol=1e-9)
    assert compared >= 3 and held >= 2


def test_transformations_compose_to_second_order():
    def own(x, p):
        return (x[0] - p) ** 2 + x[1] ** 2 * (1.0 + p**2) + x[0] * x[1]

    found = jaxatt.minimize(own, [0.0, 0.0], (0.7,), tolerance=1e-11)
    optimum = jaxatt.differentiable_minimum(found, own, (0.7,))

    # Stationary: x = [2 p, -p / (1 + p^2)] / (2 - 1 / (2 (1 + p^2))).
    def analytic(p):
        x0 = 2.0 * p / (2.0 - 0.5 / (1.0 + p**2))
        return own(jnp.stack([x0, -0.5 * x0 / (1.0 + p**2)]), p)

    for order in (jax.grad, lambda f: jax.grad(jax.grad(f))):
        got = order(lambda p: optimum(p)[0])(0.7)
        np.testing.assert_allclose(got, order(analytic)(0.7), rtol=1e-9)
    several = jnp.linspace(0.6, 0.8, 5)
    got = jax.vmap(jax.grad(lambda p: optimum(p)[1]["x"][0] ** 2))(several)
    want = jax.vmap(jax.grad(lambda p: (2.0 * p / (2.0 - 0.5 / (1.0 + p**2))) ** 2))(several)
    np.testing.assert_allclose(got, want, rtol=1e-8)


def test_bounds_are_parameters_too():
    found = jaxatt.minimize(lambda x: jnp.sum((x - 2.0) ** 2), [0.0, 0.0], upper=[1.0, 5.0])
    optimum = jaxatt.differentiable_minimum(
        found, lambda x: jnp.sum((x - 2.0) ** 2), upper=[1.0, 5.0]
    )
    record = optimum.sensitivities(["box.upper"])
    np.testing.assert_allclose(record.by_parameter, [-2.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(record.variables["x"], [[1.0, 0.0], [0.0, 0.0]], atol=1e-9)
    assert record.active == {"upper bound of x[0]": pytest.approx(2.0)}
    with pytest.raises(ValueError, match="no parameter has this name"):
        optimum.sensitivities(["box.uper"])


def _one_of(which, *choices):
    """One of several values, chosen by an argument, so that all are compiled once."""
    return jnp.stack([jnp.asarray(choice, float) for choice in choices])[which]


def sphere(x, which, p):
    return jnp.sum((x - p) ** 2) + 0.1 * x[0] * x[1]


def reached_without_force(x, which, p):
    """At p = 0 the first of two limits is reached without force."""
    return _one_of(
        which,
        [x[0], 1.0],
        [x[0] - x[1] ** 2, 1.0],
        [x[0], x[1] + 3.0],
        [jnp.sinh(x[0]), 1.0],
        [x[0] + 2.0 * x[1], 1.0],
    )


def too_many_limits(x, which, p):
    """More limits hold than their gradients can tell apart."""
    return _one_of(
        which,
        [x[0] - 1.0, 2.0 * x[0] - 2.0, 1.0],
        [x[0] - 1.0, x[1] - 1.0, x[0] + x[1] - 2.0],
        [x[0] - 1.0, x[0] - 1.0 + (x[1] - x[1]) ** 2, 1.0],
        [x[0] + x[1] - 2.0, 3.0 * (x[0] + x[1] - 2.0), 1.0],
        [jnp.exp(x[0]) - jnp.e, x[0] ** 3 - 1.0, 1.0],
    )


def without_curvature(x, which, p):
    """The objective does not curve along something that is left free."""
    return _one_of(
        which,
        (x[0] + x[1] - p) ** 2,
        (x[0] - p) ** 4 + x[1] ** 2,
        x[0] ** 2 + p,
        (x[0] * x[1] - 1.0) ** 2,
        (x[0] - x[1]) ** 6 + (x[0] + x[1] - p) ** 2,
    )


def equations_that_repeat(x, which, p):
    """Equations that say the same twice, or whose gradients vanish."""
    return _one_of(
        which,
        [x[0] - 1.0, 2.0 * x[0] - 2.0],
        [x[0] + x[1] - 1.0, x[0] ** 2 - (1.0 - x[1]) ** 2],
        [(x[0] - 1.0) ** 2, x[1] - 0.5],
        [x[0] - x[1], jnp.sin(x[0] - x[1])],
        [x[0] + x[1] - 2.0, (x[0] + x[1] - 2.0) * (2.0 + x[0])],
    )


CASES = [
    (functions, which, kind)
    for functions, kind in (
        ((sphere, None, reached_without_force), Degeneracy.WEAK_LIMIT),
        ((sphere, None, too_many_limits), Degeneracy.DEPENDENT_LIMITS),
        ((without_curvature, None, None), Degeneracy.FLAT),
        ((sphere, equations_that_repeat, None), Degeneracy.DEPENDENT_LIMITS),
    )
    for which in range(5)
]


@pytest.mark.parametrize(("functions", "which", "kind"), CASES)
def test_every_degenerate_answer_is_flagged(functions, which, kind):
    cost, equations, limits = functions
    args = (jnp.asarray(which), jnp.asarray(0.0))
    found = jaxatt.minimize(
        cost, [1.3, 0.4], args, equality=equations, inequality=limits, tolerance=1e-8
    )
    optimum = jaxatt.differentiable_minimum(
        found, cost, args, equality=equations, inequality=limits
    )
    assert kind in {flag.kind for flag in optimum.flags}
    record = optimum.sensitivities(["args"])
    assert not record.regular and np.isnan(record.variables["x"]).all()
    assert all(flag.sentence for flag in record.flags) and "\n" in repr(record)


def test_one_sided_derivatives_of_a_weakly_active_limit():
    def cost(x, p):
        return jnp.sum((x - p) ** 2)

    found = jaxatt.minimize(cost, [1.0, 1.0], (jnp.zeros(2),), inequality=lambda x, p: x)
    optimum = jaxatt.differentiable_minimum(found, cost, (jnp.zeros(2),), inequality=lambda x, p: x)
    one = optimum.sensitivities(["args"]).one_sided
    # x = max(p, 0), each for itself.
    np.testing.assert_allclose(one.forwards["x"], np.eye(2), atol=1e-9)
    np.testing.assert_allclose(one.backwards["x"], np.zeros((2, 2)), atol=1e-9)


def test_an_answer_that_met_nothing_has_no_sensitivities():
    found = jaxatt.minimize(lambda x: x[0] ** 2, [1.0], equality=lambda x: x[0] ** 2 + 1.0)
    with pytest.raises(ValueError, match="INFEASIBLE"):
        jaxatt.differentiable_minimum(
            found, lambda x: x[0] ** 2, equality=lambda x: x[0] ** 2 + 1.0
        )
