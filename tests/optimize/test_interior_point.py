"""The interior-point method against closed forms, SciPy, and starts that go wrong."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

from jaxatt.optimize.interior_point.method import InteriorPoint
from jaxatt.optimize.interior_point.state import InteriorSettings
from jaxatt.optimize.optimal_control import OptimalControlProgram, lagrangian_hessian, linearisation
from jaxatt.optimize.solver import solve
from jaxatt.optimize.status import Status

INTERVALS = 20


@functools.cache
def double_integrator(limited_rate=False, free_time=True):
    """Position, rate and the logarithm of the interval; args: distance, force, rate, fuel, step."""

    def dynamics(x, u, stage, args):
        h = jnp.exp(x[2])
        return jnp.stack([x[0] + h * x[1] + 0.5 * h * h * u[0], x[1] + h * u[0], x[2]])

    return OptimalControlProgram(
        start=lambda args: jnp.stack([jnp.zeros(()), jnp.zeros(()), jnp.log(args[4])]),
        stages=lambda args: jnp.zeros(INTERVALS),
        dynamics=dynamics,
        cost=lambda x, u, stage, args, smoothing: jnp.exp(x[2]) * (1.0 + args[3] * u[0] ** 2),
        curvature=lambda *_: None,
        error_size=3,
        inequality=(
            (lambda x, u, stage, args: (args[2] - x[1])[None])
            if limited_rate
            else (lambda x, u, stage, args: jnp.zeros((0,)))
        ),
        final_rows=lambda x, args: jnp.stack([x[0] - args[0], x[1]]),
        limits=lambda stage, args: (-args[1], args[1]),
        free_start=1 if free_time else 0,
    )


@functools.partial(jax.jit, static_argnames=("program",))
def solved(program, u, args, crossover_from=1e-3):
    def one(u, args):
        x = jnp.broadcast_to(program.start(args), (INTERVALS + 1, 3))
        method = InteriorPoint(InteriorSettings(crossover_from=crossover_from))
        return solve(method, program, (u, x), args)

    return jax.vmap(one)(u, args)


def arguments(rng, count, fuel=0.0, rate=np.inf):
    distance, force = rng.uniform(0.5, 5.0, count), rng.uniform(0.2, 3.0, count)
    full = np.ones(count)
    return tuple(map(jnp.asarray, (distance, force, rate * full, fuel * full, 0.1 * full)))


def test_least_time_of_the_double_integrator():
    args = arguments(np.random.default_rng(1), 16)
    found = solved(double_integrator(), jnp.zeros((16, INTERVALS, 1)), args)
    assert (found.status == Status.CONVERGED).all()
    # The switch falls on a node: the grid costs nothing.
    exact = 2.0 * np.sqrt(np.asarray(args[0]) / np.asarray(args[1]))
    np.testing.assert_allclose(found.objective, exact, rtol=1e-6)
    half = np.asarray(found.u)[:, : INTERVALS // 2, 0] / np.asarray(args[1])[:, None]
    np.testing.assert_allclose(half, 1.0, atol=1e-5)


def test_least_time_with_a_limit_on_the_rate_is_a_trapezium():
    rng = np.random.default_rng(2)
    force, rate, ramps = rng.uniform(0.5, 2.0, 8), rng.uniform(0.5, 2.0, 8), 4
    # Ramps of four intervals and a coast of twelve: again all corners are nodes.
    ramp = rate / force
    distance = rate * ramp * (1.0 + (INTERVALS - 2 * ramps) / ramps)
    args = tuple(map(jnp.asarray, (distance, force, rate, 0.0 * force, 0.1 + 0.0 * force)))
    found = solved(double_integrator(True), jnp.zeros((8, INTERVALS, 1)), args)
    assert (found.status == Status.CONVERGED).all()
    np.testing.assert_allclose(found.objective, distance / rate + ramp, rtol=1e-6)
    assert (np.asarray(found.x)[..., 1] <= rate[:, None] + 1e-7).all()


def test_without_limits_that_bind_the_controls_are_the_least_squares():
    args = arguments(np.random.default_rng(3), 6, fuel=1.0)
    args = (args[0], 50.0 + 0.0 * args[1], *args[2:])
    found = solved(double_integrator(free_time=False), jnp.zeros((6, INTERVALS, 1)), args)
    assert (found.status == Status.CONVERGED).all()
    h = 0.1
    late = h * (np.arange(INTERVALS)[::-1] + 0.5)
    rows = np.stack([h * late, np.full(INTERVALS, h)])
    for u, distance in zip(np.asarray(found.u)[..., 0], np.asarray(args[0]), strict=True):
        # A rate large enough for the distance needs more than the limit at most of the draws.
        exact = np.linalg.pinv(rows) @ np.array([distance, 0.0])
        if np.abs(exact).max() < 45.0:
            np.testing.assert_allclose(u, exact, rtol=1e-5, atol=1e-5)


def test_limits_that_bind_agree_with_scipy():
    distance, force, h = 1.0, 1.25, 0.1
    full = jnp.ones(1)
    args = (distance * full, force * full, np.inf * full, full, h * full)
    found = solved(double_integrator(free_time=False), jnp.zeros((1, INTERVALS, 1)), args)
    late = h * (np.arange(INTERVALS)[::-1] + 0.5)
    rows = np.stack([h * late, np.full(INTERVALS, h)])
    other = scipy.optimize.minimize(
        lambda u: h * (u @ u),
        np.zeros(INTERVALS),
        jac=lambda u: 2.0 * h * u,
        bounds=[(-force, force)] * INTERVALS,
        constraints={
            "type": "eq",
            "fun": lambda u: rows @ u - [distance, 0.0],
            "jac": lambda u: rows,
        },
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert found.status[0] == Status.CONVERGED
    assert np.abs(np.asarray(found.u)).max() > 0.999 * force
    assert float(found.objective[0]) - INTERVALS * h == pytest.approx(other.fun, rel=1e-6)


def test_what_cannot_be_reached_is_not_called_converged():
    full = jnp.ones(2)
    args = (jnp.asarray([100.0, 0.5]), full, np.inf * full, full, 0.1 * full)
    found = solved(double_integrator(free_time=False), jnp.zeros((2, INTERVALS, 1)), args)
    assert found.status[0] in (Status.INFEASIBLE, Status.ITERATION_LIMIT)
    assert found.violation[0] > 1.0
    assert found.status[1] == Status.CONVERGED


def test_a_start_that_is_not_a_number_leaves_the_others_as_they_are():
    args = arguments(np.random.default_rng(4), 3)
    u = jnp.zeros((3, INTERVALS, 1))
    clean = solved(double_integrator(), u, args)
    spoilt = solved(double_integrator(), u.at[1, 3, 0].set(jnp.nan), args)
    assert spoilt.status[1] == Status.NOT_FINITE
    for lane in (0, 2):
        np.testing.assert_array_equal(np.asarray(clean.u)[lane], np.asarray(spoilt.u)[lane])


def test_converged_is_true_of_the_point_returned():
    """The conditions for a minimum, put together again from the programme's own derivatives."""
    program = double_integrator()
    args = arguments(np.random.default_rng(10), 4, fuel=0.3)
    found = solved(program, jnp.zeros((4, INTERVALS, 1)), args)
    assert (found.status == Status.CONVERGED).all()
    derivatives = jax.jit(functools.partial(linearisation, program))
    for lane in range(4):
        own = tuple(a[lane] for a in args)
        x, u = found.x[lane], found.u[lane]
        costate = np.array([*np.asarray(found.rows)[lane], 0.0])
        worst = 0.0
        for k in range(INTERVALS - 1, -1, -1):
            at = derivatives(x[k], u[k], x[k + 1], jnp.zeros(()), own)
            assert np.abs(np.asarray(at.gap)).max() < 1e-7
            gradient = np.asarray(at.cost) + np.asarray(at.dynamics).T @ costate
            dual = np.asarray(found.dual.upper)[lane, k] - np.asarray(found.dual.lower)[lane, k]
            worst = max(worst, abs(float(gradient[3] + dual[0])))
            costate = gradient[:3]
        assert max(worst, abs(costate[2])) < 1e-6


def test_derivatives_of_a_stage_are_those_of_finite_differences():
    program, rng = double_integrator(), np.random.default_rng(5)
    args = tuple(jnp.asarray(v) for v in (1.0, 1.0, np.inf, 0.4, 0.1))
    x, u = jnp.asarray([*rng.normal(size=2), np.log(0.3)]), jnp.asarray(rng.normal(size=1))
    costate = jnp.asarray(rng.normal(size=3))

    def lagrangian(z):
        gap = program.dynamics(x + z[:3], u + z[3:], 0.0, args) - x
        return program.cost(x + z[:3], u + z[3:], 0.0, args, 0.0) + costate @ gap

    own = lagrangian_hessian(program, x, u, x, jnp.zeros(()), args, costate)
    eye = 1e-4 * np.eye(4)
    for i in range(4):
        for j in range(4):
            corners = [lagrangian(s * eye[i] + t * eye[j]) for s in (1, -1) for t in (1, -1)]
            other = (corners[0] - corners[1] - corners[2] + corners[3]) / 4e-8
            assert float(own[i, j]) == pytest.approx(float(other), abs=2e-6)


def test_a_limit_without_force_does_not_slow_the_end():
    """Pairs that are nearly zero on both sides only halve under a barrier; the crossover ends
    them.
    """
    rng = np.random.default_rng(11)
    distance, force = rng.uniform(0.5, 5.0, 16), rng.uniform(0.2, 3.0, 16)
    # The unlimited optimum falls linearly from 1 / sqrt(fuel): in the first interval to the limit.
    fuel = ((1.0 - 1.0 / INTERVALS) / force) ** 2
    args = tuple(map(jnp.asarray, (distance, force, np.full(16, np.inf), fuel, np.full(16, 0.1))))
    program, u = double_integrator(), jnp.zeros((16, INTERVALS, 1))
    fast, slow, early = (solved(program, u, args, start) for start in (1e-3, 0.0, 1.0))
    for found in (fast, slow, early):
        assert (found.status == Status.CONVERGED).all()
        np.testing.assert_allclose(found.objective, slow.objective, rtol=1e-7)
    assert (fast.iterations <= slow.iterations).all()
    assert fast.iterations.mean() < slow.iterations.mean() - 2.0
    assert (np.abs(fast.u[..., 0]) <= force[:, None]).all()


def test_passes_leave_a_state_of_the_same_types():
    """A weak type among them would make every caller compile its passes twice."""
    program, method = double_integrator(), InteriorPoint(InteriorSettings())
    args = (1.0, 1.0, np.inf, 0.0, 0.1)
    x = jnp.zeros((INTERVALS + 1, 3))
    u = jnp.zeros((INTERVALS, 1))
    start = jax.eval_shape(lambda u: method.init(program, (u, x), args), u)
    later = jax.eval_shape(lambda state: method.step(program, state, args), start)
    for a, b in zip(jax.tree.leaves(start), jax.tree.leaves(later), strict=True):
        assert (a.shape, a.dtype) == (b.shape, b.dtype)
        assert not b.weak_type
