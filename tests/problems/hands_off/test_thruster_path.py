"""Path constraints of slews with thrusters: derivatives, and steps that respect them."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt import scenarios
from jaxatt.optimize.reweighting.bounded import bounded_step
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.slew.thruster_path import path_response
from jaxatt.problems.hands_off.slew.thruster_response import fly_thrusters
from jaxatt.problems.pointing.cones import pointing_margins

CASE = {"horizon.intervals": 45, "limits.body_rate_deg_s": 30.0}


def test_worst_margins_and_their_derivatives():
    task = build_slew(scenarios.replace(scenarios.load("eseo-1-keep-out"), CASE))
    task = task.enforcing(np.zeros(3), False)
    plant, rng = task.arguments.plant, np.random.default_rng(4)
    u = jnp.asarray(0.15 * rng.uniform(size=(task.intervals, task.size)))
    way = jnp.asarray(rng.normal(size=u.shape))
    run = jax.jit(lambda u: path_response(u, plant, task.form))
    rows, derivatives = run(u)
    assert rows.shape == (9,) and derivatives.shape == (45, 9, task.size)
    step = 1e-5
    ahead, behind = (run(u + s * step * way)[0] for s in (1, -1))
    numeric = (ahead - behind) / (2 * step)
    found = jnp.einsum("kib,kb->i", derivatives, way)
    np.testing.assert_allclose(found, numeric, atol=5e-3 * float(jnp.abs(numeric).max()))
    # Each row is the worst of its kind, up to what is allowed for the way between the nodes.
    nodes = fly_thrusters(u, plant, task.form)[1]
    limits, toward = plant.pointing.limits, plant.pointing.directions[1:]
    every = jax.vmap(lambda x, d: pointing_margins(x[:4], x[4:7], d, limits))(nodes, toward)
    for cone in range(2):
        assert float(rows[cone:6:2].min()) <= float(every[:, cone].min()) + 1e-12
    for axis in range(3):
        np.testing.assert_allclose(rows[6 + axis], every[:, [2 + axis, 5 + axis]].min(), rtol=1e-12)


def test_steps_meet_one_sided_rows_and_waste_nothing_on_those_that_hold():
    """Against the same quadratic programme by SciPy."""
    from scipy.optimize import minimize

    rng = np.random.default_rng(6)
    count, size, ends, path = 5, 12, 2, 3
    jacobian = rng.normal(size=(count, ends + path, size))
    d = rng.uniform(0.5, 2.0, size=(count, size))
    lower, upper = np.zeros((count, size)), np.ones((count, size))
    inside = rng.uniform(0.2, 0.8, size=(count, size))
    target = np.einsum("sim,sm->si", jacobian, inside)
    target[:, ends:] -= rng.choice([0.0, 2.0], size=(count, path))
    slack = 1e-13 * np.sum(jacobian**2 * d[:, None], axis=-1)
    steps = jax.jit(jax.vmap(lambda *parts: bounded_step(*parts, 60, path)))
    v, dual = steps(
        *map(jnp.asarray, (jacobian, target, d, lower, upper, slack, np.zeros_like(target)))
    )
    v, left = np.asarray(v), np.einsum("sim,sm->si", jacobian, np.asarray(v)) - target
    np.testing.assert_allclose(left[:, :ends], 0.0, atol=1e-6)
    assert (left[:, ends:] >= -1e-6).all() and (np.asarray(dual)[:, ends:] >= 0.0).all()
    for s in range(count):
        j, t, w = jacobian[s], target[s], d[s]
        best = minimize(
            lambda x, w=w: 0.5 * np.sum(x**2 / w),
            inside[s],
            jac=lambda x, w=w: x / w,
            bounds=list(zip(lower[s], upper[s], strict=True)),
            constraints=[
                {"type": "eq", "fun": lambda x, j=j, t=t: j[:ends] @ x - t[:ends]},
                {"type": "ineq", "fun": lambda x, j=j, t=t: j[ends:] @ x - t[ends:]},
            ],
            options={"ftol": 1e-13, "maxiter": 500},
        )
        np.testing.assert_allclose(np.sum(v[s] ** 2 / w), 2.0 * best.fun, rtol=1e-5)
