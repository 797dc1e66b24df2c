"""The staged augmented Lagrangian against SciPy, and what its statuses promise."""

import functools
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.optimal_control import OptimalControlProgram, fly, least_squares
from jaxatt.optimize.riccati.lagrangian import RiccatiLagrangian
from jaxatt.optimize.solver import solve
from jaxatt.optimize.status import Status

SCHEDULE = Schedule(
    penalty=10.0,
    stage_penalty=10.0,
    smoothing_start=1e-4,
    smoothing_end=1e-4,
    max_inner=20,
    max_iterations=200,
)
STAGES, STEP = 15, 0.2


def residual(x, u, stage, args):
    return jnp.concatenate([0.1 * x, u])


def linear(x, u, stage, args):
    return jnp.stack([x[0] + STEP * x[1], x[1] + STEP * u[0]])


def pendulum(x, u, stage, args):
    rate = x[1] + STEP * (u[0] - jnp.sin(x[0]))
    return jnp.stack([x[0] + STEP * rate, rate])


def program(dynamics):
    """Drive two states to args[:2] with |u| <= args[2] and x[1] <= args[3]."""
    cost, curvature = least_squares(residual, 2)
    return OptimalControlProgram(
        start=lambda args: jnp.zeros(2),
        stages=lambda args: jnp.zeros(STAGES),
        dynamics=dynamics,
        cost=cost,
        curvature=curvature,
        error_size=2,
        inequality=lambda x, u, stage, args: jnp.stack(
            [args[2] - u[0], args[2] + u[0], args[3] - x[1]]
        ),
        final_rows=lambda x, args: x - args[:2],
    )


def scipy_answer(dynamics, args):
    staged = program(dynamics)

    @jax.jit
    def values(u):
        x, end = fly(staged, u[:, None], args)
        cost = 0.5 * jnp.sum(0.01 * x**2) + 0.5 * jnp.sum(u**2)
        return cost, end - args[:2], args[3] - x[:, 1]

    def part(i):
        gradient = jax.jit((jax.grad if i == 0 else jax.jacfwd)(lambda u: values(u)[i]))
        return lambda u: np.asarray(values(u)[i]), lambda u: np.asarray(gradient(u))

    (f, df), (h, dh), (g, dg) = part(0), part(1), part(2)
    limit = float(args[2])
    found = scipy.optimize.minimize(
        f,
        np.zeros(STAGES),
        jac=df,
        method="SLSQP",
        bounds=[(-limit, limit)] * STAGES,
        constraints=[{"type": "eq", "fun": h, "jac": dh}, {"type": "ineq", "fun": g, "jac": dg}],
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert found.success
    return found


@functools.cache
def solver(dynamics):
    """Lanes last: controls (N, b, S), arguments (4, S)."""
    return jax.jit(
        lambda u, args, schedule: jax.vmap(
            lambda u, a: solve(RiccatiLagrangian(schedule), program(dynamics), u, a),
            in_axes=-1,
            out_axes=-1,
        )(u, args)
    )


REACHABLE = np.array([1.2, 0.0, 1.5, 0.55])
FREE = np.array([1.2, 0.0, 50.0, 50.0])
IMPOSSIBLE = np.array([9.0, 0.0, 0.1, 0.1])
BROKEN = np.array([np.nan, 0.0, 1.0, 1.0])


@pytest.mark.parametrize("dynamics", [linear, pendulum])
def test_bounds_and_path_constraints_as_scipy_has_them(dynamics):
    args = np.stack([REACHABLE, FREE, IMPOSSIBLE, BROKEN], axis=-1)
    solution = solver(dynamics)(jnp.zeros((STAGES, 1, 4)), jnp.asarray(args), SCHEDULE)
    status = np.asarray(solution.status)
    for lane, case in enumerate([REACHABLE, FREE]):
        best = scipy_answer(dynamics, jnp.asarray(case))
        assert status[lane] == Status.CONVERGED
        assert float(solution.violation[lane]) <= SCHEDULE.tolerance
        np.testing.assert_allclose(solution.objective[lane], best.fun, rtol=1e-8)
        np.testing.assert_allclose(solution.x[:, 0, lane], best.x, atol=2e-5)
    assert float(solution.states[:, 1, 0].max()) == pytest.approx(0.55, abs=1e-8)
    assert status[2] in (Status.INFEASIBLE, Status.ITERATION_LIMIT)
    assert float(solution.violation[2]) > 1e-3
    assert status[3] == Status.NOT_FINITE


def test_a_broken_lane_leaves_the_others_as_they_are():
    u = jnp.zeros((STAGES, 1, 4))
    rng = np.random.default_rng(0)
    targets = REACHABLE[:, None] + np.array([1.0, 0.1, 0.0, 0.0])[:, None] * (
        0.3 * rng.normal(size=(1, 4))
    )
    whole = solver(pendulum)(u, jnp.asarray(targets), SCHEDULE)
    spoilt = targets.copy()
    spoilt[:, 2] = BROKEN
    other = solver(pendulum)(u, jnp.asarray(spoilt), SCHEDULE)
    kept = [0, 1, 3]
    np.testing.assert_array_equal(whole.x[..., kept], other.x[..., kept])
    np.testing.assert_array_equal(whole.status[jnp.array(kept)], other.status[jnp.array(kept)])
    assert int(other.status[2]) == Status.NOT_FINITE


def test_an_early_end_is_said_to_be_one():
    args = jnp.asarray(np.stack([REACHABLE] * 4, axis=-1))
    few = replace(SCHEDULE, max_iterations=2)
    solution = solver(pendulum)(jnp.zeros((STAGES, 1, 4)), args, few)
    assert set(np.asarray(solution.status).tolist()) <= {
        int(Status.ITERATION_LIMIT),
        int(Status.FEASIBLE),
    }
    assert float(solution.violation[0]) > SCHEDULE.tolerance
