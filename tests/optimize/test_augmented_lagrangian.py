"""The augmented Lagrangian on problems whose answers are known from elsewhere."""

import functools
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from jax import Array

from jaxatt.optimize.augmented_lagrangian.inner import NAMES
from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.program import Program
from jaxatt.optimize.solver import solve
from jaxatt.optimize.status import Status

STAGES, SIZE, LANES = 6, 2, 32
COMMON = {"penalty": 10.0, "stage_penalty": 10.0, "tolerance": 1e-7, "stationarity": 1e-7}
SETTINGS = {
    "gauss-newton": {**COMMON, "max_iterations": 200},
    "lbfgs": {
        **COMMON,
        "tolerance": 1e-5,
        "stationarity": 1e-5,
        "max_inner": 100,
        "max_iterations": 3000,
    },
    "adam": {
        **COMMON,
        "tolerance": 1e-3,
        "stationarity": 1e-3,
        "max_inner": 1500,
        "max_iterations": 20000,
    },
}


class Quadratic(NamedTuple):
    """1/2 x'Hx + g'x with A x = a, C x >= c, low <= x <= high, held variables and soft rows."""

    hessian: Array
    gradient: Array
    equality: Array
    equal_to: Array
    inequality: Array
    at_least: Array
    low: Array
    high: Array
    row_weight: Array
    free: Array


QP = Program(
    objective=lambda x, q, s: (
        0.5 * jnp.einsum("ki,kij,kj->", x, q.hessian, x) + jnp.vdot(q.gradient, x)
    ),
    curvature=lambda x, q, s: q.hessian,
    equality=lambda x, q: jnp.einsum("mki,ki->m", q.equality, x) - q.equal_to,
    equality_weight=lambda x, q: q.row_weight,
    inequality=lambda x, q: jnp.einsum("pki,ki->p", q.inequality, x) - q.at_least,
    stage_inequality=lambda x, q: jnp.concatenate([x - q.low, q.high - x], axis=1),
    free=lambda x, q: q.free,
)


def draw(rng):
    """A strictly convex feasible problem; bounds and inequalities are active in most."""
    factors = rng.normal(size=(STAGES, SIZE, SIZE))
    inside = rng.uniform(-0.8, 0.8, (STAGES, SIZE))
    rows, above = rng.normal(size=(2, STAGES, SIZE)), rng.normal(size=(3, STAGES, SIZE))
    return Quadratic(
        factors @ factors.swapaxes(1, 2) + 0.3 * np.eye(SIZE),
        3.0 * rng.normal(size=(STAGES, SIZE)),
        rows,
        np.einsum("mki,ki->m", rows, inside),
        above,
        np.einsum("pki,ki->p", above, inside) - rng.uniform(0.0, 1.0, 3),
        np.full((STAGES, SIZE), -1.0),
        np.full((STAGES, SIZE), 1.0),
        np.full(2, np.inf),
        np.ones((STAGES, SIZE)),
    )


@functools.partial(jax.jit, static_argnames="inner")
def solve_all(x, problems, schedule, inner):
    one = lambda x, q: solve(AugmentedLagrangian(schedule, inner), QP, x, q)  # noqa: E731
    return jax.vmap(one)(x, problems)


def run(x, problems, inner="gauss-newton", **changes):
    settings = {**SETTINGS[inner], **changes}
    found = solve_all(jnp.asarray(x), problems, Schedule(**settings), inner)
    return jax.tree.map(np.asarray, found)


def stacked(problems):
    return Quadratic(*(jnp.asarray(np.stack(leaf)) for leaf in zip(*problems, strict=True)))


@pytest.fixture(scope="module")
def problems():
    rng = np.random.default_rng(0)
    return [draw(rng) for _ in range(LANES)]


@pytest.fixture(scope="module")
def begin():
    return np.random.default_rng(1).normal(size=(LANES, STAGES, SIZE))


def flat_constraints(q):
    """Inequalities of one problem as G x >= h."""
    n = STAGES * SIZE
    rows = np.concatenate([q.inequality.reshape(-1, n), np.eye(n), -np.eye(n)])
    return rows, np.concatenate([q.at_least, q.low.ravel(), -q.high.ravel()])


def hessian_of(q):
    return scipy.linalg.block_diag(*q.hessian)


def kkt_residuals(q, x, active_within):
    """Violation, and the least gradient of the Lagrangian over all admissible multipliers."""
    n = STAGES * SIZE
    x = x.ravel()
    rows, least = flat_constraints(q)
    equality = q.equality.reshape(-1, n)
    violation = max(
        np.abs(equality @ x - q.equal_to).max(), np.maximum(0.0, least - rows @ x).max()
    )
    active = rows[rows @ x - least < active_within]
    gradient = hessian_of(q) @ x + q.gradient.ravel()
    basis = np.concatenate([equality, active]).T
    free = np.concatenate([np.full(len(equality), -np.inf), np.zeros(len(active))])
    fit = scipy.optimize.lsq_linear(basis, gradient, bounds=(free, np.inf), tol=1e-14)
    return violation, np.linalg.norm(gradient - basis @ fit.x), np.abs(fit.x).max(initial=0.0)


def reference(q):
    """The same problem by SciPy, its active set then solved exactly and proved optimal."""
    n = STAGES * SIZE
    hessian, gradient = hessian_of(q), q.gradient.ravel()
    equality = q.equality.reshape(-1, n)
    rows, least = flat_constraints(q)
    rough = scipy.optimize.minimize(
        lambda x: 0.5 * x @ hessian @ x + gradient @ x,
        np.zeros(n),
        jac=lambda x: hessian @ x + gradient,
        method="SLSQP",
        constraints=[
            {"type": "eq", "fun": lambda x: equality @ x - q.equal_to, "jac": lambda x: equality},
            {"type": "ineq", "fun": lambda x: rows @ x - least, "jac": lambda x: rows},
        ],
        options={"ftol": 1e-12, "maxiter": 500},
    ).x
    active = rows @ rough - least < 1e-5
    tight = np.concatenate([equality, rows[active]])
    kkt = np.block([[hessian, tight.T], [tight, np.zeros((len(tight), len(tight)))]])
    right = np.concatenate([-gradient, q.equal_to, least[active]])
    answer = np.linalg.solve(kkt, right)
    x, multipliers = answer[:n], -answer[n + len(equality) :]
    # Convex, so these two make it the optimum whatever found the active set.
    assert (multipliers >= -1e-9).all()
    assert (rows @ x - least >= -1e-9).all()
    return x.reshape(STAGES, SIZE)


@pytest.mark.parametrize(
    ("inner", "share", "close"),
    [("gauss-newton", 1.0, 1e-5), ("lbfgs", 1.0, 1e-3), ("adam", 0.5, 2e-2)],
)
def test_random_quadratic_programmes_against_scipy(problems, begin, inner, share, close):
    found = run(begin, stacked(problems), inner)
    converged = found.status == Status.CONVERGED
    assert converged.mean() >= share
    active = 0
    for lane in np.flatnonzero(converged):
        expected = reference(problems[lane])
        np.testing.assert_allclose(found.x[lane], expected, atol=close)
        rows, least = flat_constraints(problems[lane])
        active += int((rows @ expected.ravel() - least < 1e-6).sum())
    assert active > LANES  # or the inequalities would not have been tried


@pytest.mark.parametrize("inner", NAMES)
def test_converged_is_said_only_where_it_is_true(problems, begin, inner):
    tolerance = SETTINGS[inner]["tolerance"]
    found = run(begin, stacked(problems), inner)
    lanes = np.flatnonzero(found.status == Status.CONVERGED)
    assert len(lanes)
    for lane in lanes:
        # A row whose slack is below the multiplier it bears over the penalty counts as active.
        violation, stationarity, largest = kkt_residuals(
            problems[lane], found.x[lane], 10 * tolerance
        )
        assert violation <= tolerance * (1 + 1e-6)
        # The least Euclidean norm is at most that of what the solver found, entries <= tolerance.
        entries = np.sqrt(STAGES * SIZE)
        assert stationarity <= entries * tolerance * max(1.0, largest / 100.0) + 1e-9
        np.testing.assert_allclose(found.violation[lane], violation, rtol=1e-6, atol=1e-15)


FLOOR = Program(
    objective=lambda x, args, s: 0.5 * jnp.sum(x**2),
    curvature=lambda x, args, s: jnp.ones((1, 1, 1)),
    stage_inequality=lambda x, args: x - 1.0,
)


def test_converged_means_complementary_too():
    schedule = Schedule(max_inner=1, smoothing_start=1e-4, penalty=10.0, stage_penalty=10.0)
    found = solve(AugmentedLagrangian(schedule), FLOOR, jnp.full((1, 1), 5.0), None)
    if int(found.status) == Status.CONVERGED:
        np.testing.assert_allclose(found.x, 1.0, atol=1e-5)


@pytest.mark.parametrize("begin", [5.0, 1.0, 0.0, -5.0])
def test_a_floor_is_found_from_both_sides_with_the_default_schedule(begin):
    found = solve(AugmentedLagrangian(Schedule()), FLOOR, jnp.full((1, 1), begin), None)
    assert int(found.status) == Status.CONVERGED
    np.testing.assert_allclose(found.x, 1.0, atol=1e-6)


def test_too_few_iterations_are_admitted(problems, begin):
    found = run(begin, stacked(problems), max_iterations=2)
    assert (found.iterations <= 2).all()
    assert not (found.status == Status.CONVERGED).any()
    held = found.violation <= SETTINGS["gauss-newton"]["tolerance"]
    np.testing.assert_array_equal(found.status == Status.FEASIBLE, held)
    np.testing.assert_array_equal(found.status == Status.ITERATION_LIMIT, ~held)


def test_equality_constrained_quadratic_with_known_multipliers(problems, begin):
    wide = [
        q._replace(low=-1e3 + q.low, high=1e3 + q.high, at_least=q.at_least - 1e4) for q in problems
    ]
    found = run(begin, stacked(wide))
    assert (found.status == Status.CONVERGED).all()
    n = STAGES * SIZE
    for lane, q in enumerate(wide):
        rows = q.equality.reshape(-1, n)
        kkt = np.block([[hessian_of(q), rows.T], [rows, np.zeros((2, 2))]])
        answer = np.linalg.solve(kkt, np.concatenate([-q.gradient.ravel(), q.equal_to]))
        np.testing.assert_allclose(found.x[lane].ravel(), answer[:n], atol=1e-6)
        np.testing.assert_allclose(found.multipliers.equality[lane], answer[n:], atol=1e-4)
        assert not found.multipliers.inequality[lane].any()
        assert not found.multipliers.stage[lane].any()


def test_returned_multipliers_make_the_lagrangian_stationary(problems, begin):
    tolerance = 1e-7
    found = run(begin, stacked(problems), penalty=1e4, stage_penalty=1e2, tolerance=tolerance)
    assert (found.status == Status.CONVERGED).all()
    for lane, q in enumerate(problems):
        m = jax.tree.map(lambda leaf, lane=lane: leaf[lane], found.multipliers)
        gradient = (
            np.einsum("kij,kj->ki", q.hessian, found.x[lane])
            + q.gradient
            + np.einsum("m,mki->ki", m.equality, q.equality)
            - np.einsum("p,pki->ki", m.inequality, q.inequality)
            - m.stage[:, :SIZE]
            + m.stage[:, SIZE:]
        )
        largest = max(np.abs(leaf).max() for leaf in m)
        assert np.abs(gradient).max() <= 1.01 * Schedule().stationarity * max(1.0, largest / 100.0)


def test_multipliers_tell_active_from_inactive(problems, begin):
    found = run(begin, stacked(problems))
    assert (found.status == Status.CONVERGED).all()
    for lane, q in enumerate(problems):
        slack = np.einsum("pki,ki->p", q.inequality, found.x[lane]) - q.at_least
        bound = np.concatenate([found.x[lane] - q.low, q.high - found.x[lane]], axis=1)
        for multiplier, room in (
            (found.multipliers.inequality[lane], slack),
            (found.multipliers.stage[lane], bound),
        ):
            assert (multiplier >= 0).all()
            assert not (multiplier[room > 1e-4] > 1e-6).any()


def test_soft_rows_are_weighted_least_squares(problems, begin):
    rng = np.random.default_rng(2)
    n = STAGES * SIZE
    soft = [
        q._replace(
            low=q.low - 1e3,
            high=q.high + 1e3,
            at_least=q.at_least - 1e4,
            row_weight=rng.uniform(0.1, 50.0, 2),
        )
        for q in problems
    ]
    found = run(begin, stacked(soft))
    assert (found.status == Status.CONVERGED).all()
    assert found.violation.max() == 0.0  # a soft row is no constraint
    for lane, q in enumerate(soft):
        rows = q.equality.reshape(-1, n)
        hessian = hessian_of(q) + rows.T @ np.diag(q.row_weight) @ rows
        right = rows.T @ (q.row_weight * q.equal_to) - q.gradient.ravel()
        np.testing.assert_allclose(
            found.x[lane].ravel(), np.linalg.solve(hessian, right), atol=1e-6
        )


def test_held_variables_do_not_move(problems, begin):
    rng = np.random.default_rng(3)
    held = [
        q._replace(
            free=(rng.random((STAGES, SIZE)) < 0.7).astype(float),
            low=q.low - 10.0,
            high=q.high + 10.0,
            at_least=q.at_least - 100.0,
        )
        for q in problems
    ]
    found = run(begin, stacked(held))
    still = np.stack([q.free for q in held]) == 0
    assert still.any()
    np.testing.assert_array_equal(found.x[still], begin[still])
    assert (found.status == Status.CONVERGED).mean() > 0.9


@pytest.mark.parametrize("inner", ["gauss-newton", "lbfgs"])
def test_contradictory_rows_never_converge(problems, begin, inner):
    contradictory = [
        q._replace(
            equality=np.stack([q.equality[0]] * 2),
            equal_to=np.array([q.equal_to[0], q.equal_to[0] + 1.0]),
        )
        for q in problems
    ]
    found = run(begin, stacked(contradictory), inner)
    assert set(found.status) <= {int(Status.INFEASIBLE), int(Status.ITERATION_LIMIT)}
    # The rows differ by one, so the best that can be done is half of it.
    assert found.violation.min() >= 0.5 - 1e-9
    if inner == "gauss-newton":
        assert (found.status == Status.INFEASIBLE).all()


@pytest.mark.parametrize("spoilt", ["hessian", "gradient", "equal_to", "low"])
def test_a_lane_of_nans_leaves_the_others_alone(problems, begin, spoilt):
    clean = run(begin, stacked(problems))
    lane = 5
    bad = list(problems)
    leaf = getattr(bad[lane], spoilt)
    bad[lane] = bad[lane]._replace(**{spoilt: leaf * np.nan})
    found = run(begin, stacked(bad))
    assert found.status[lane] == Status.NOT_FINITE
    others = np.arange(LANES) != lane
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(clean), strict=True):
        np.testing.assert_array_equal(a[others], b[others])


def test_a_start_of_nans_is_called_not_finite(problems, begin):
    spoilt = begin.copy()
    spoilt[7, 2, 1] = np.nan
    found = run(spoilt, stacked(problems))
    assert found.status[7] == Status.NOT_FINITE
    assert (np.delete(found.status, 7) == Status.CONVERGED).all()


CIRCLE = Program(
    objective=lambda x, a, s: 0.5 * jnp.sum((x - a) ** 2),
    curvature=lambda x, a, s: jnp.ones((1, 2, 2)) * jnp.eye(2)[None],
    equality=lambda x, a: jnp.sum(x**2)[None] - 1.0,
)


def test_nearest_point_of_a_circle():
    rng = np.random.default_rng(4)
    angle = rng.uniform(0, 2 * np.pi, LANES)
    size = np.concatenate([rng.uniform(0.2, 0.9, LANES // 2), rng.uniform(1.1, 3.0, LANES // 2)])
    a = size[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)[:, None]
    x = rng.normal(size=a.shape)
    schedule = Schedule(penalty=10.0, stationarity=1e-8, max_iterations=300)

    @jax.jit
    def run_all(x, a):
        one = lambda x, a: solve(AugmentedLagrangian(schedule), CIRCLE, x, a)  # noqa: E731
        return jax.vmap(one)(x, a)

    found = jax.tree.map(np.asarray, run_all(jnp.asarray(x), jnp.asarray(a)))
    assert (found.status == Status.CONVERGED).all()
    np.testing.assert_allclose(found.x, a / size[:, None, None], atol=1e-6)
    # Stationarity of the Lagrangian at the nearest point: (x - a) + 2 lambda x = 0.
    np.testing.assert_allclose(found.multipliers.equality[:, 0], (size - 1) / 2, atol=1e-4)


class Budget(NamedTuple):
    """Reach gain' x = needed with few non-zero x; xi x within eps."""

    gain: Array
    needed: Array
    eps: Array


RELAXED = Program(
    objective=lambda v, p, s: jnp.sum(1.0 - v[:, 1]),
    # The objective is linear; a little curvature keeps the steps short.
    curvature=lambda v, p, s: jnp.full((STAGES, 1, 1), 0.1) * jnp.eye(2)[None],
    equality=lambda v, p: (jnp.vdot(p.gain, v[:, 0]) - p.needed)[None],
    stage_inequality=lambda v, p: jnp.stack(
        [
            p.eps - v[:, 1] * v[:, 0],
            p.eps + v[:, 1] * v[:, 0],
            v[:, 1],
            1.0 - v[:, 1],
            1.0 - v[:, 0],
            1.0 + v[:, 0],
        ],
        axis=1,
    ),
)


def test_relaxed_complementarity_with_its_own_variables():
    gain, needed, eps = np.array([1.0, 0.5, -0.7, 0.9, 0.3, 1.2]), 2.0, 1e-3
    rng = np.random.default_rng(5)
    x = np.stack([rng.uniform(-1, 1, (LANES, 6)), rng.uniform(0, 1, (LANES, 6))], axis=-1)
    schedule = Schedule(penalty=10.0, stage_penalty=1.0, max_inner=15, max_iterations=1000)
    budget = Budget(jnp.asarray(gain), jnp.asarray(needed), jnp.asarray(eps))

    @jax.jit
    def run_all(x):
        one = lambda x: solve(AugmentedLagrangian(schedule), RELAXED, x, budget)  # noqa: E731
        return jax.vmap(one)(x)

    found = jax.tree.map(np.asarray, run_all(jnp.asarray(x)))
    converged = found.status == Status.CONVERGED
    assert converged.mean() > 0.9
    torque, xi = found.x[converged, :, 0], found.x[converged, :, 1]
    slack = 2e-7
    assert np.abs(torque @ gain - needed).max() <= slack
    assert np.abs(torque * xi).max() <= eps + slack
    assert np.abs(torque).max() <= 1 + slack
    assert (xi >= -slack).all() and (xi <= 1 + slack).all()
    # Two entries can bring 2.2 and one only 1.2; those idle at eps may chip in eps each.
    active = (np.abs(torque) > 10 * eps).sum(axis=1)
    assert active.min() == 2
    best = found.objective[converged].min()
    # xi = eps / |x| is left to the two that are active, |x| <= 1 and 0.667 at the least.
    assert 2.0 - 2.6 * eps <= best <= 2.0 - 2.0 * eps + 1e-6
    assert (found.objective[converged] >= 2.0 - 2.6 * eps).all()
