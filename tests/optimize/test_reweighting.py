"""Sparse roots against brute force, linear programming and the limits themselves."""

import functools
import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize

from jaxatt.optimize.reweighting.condensed import CondensedReweighting
from jaxatt.optimize.reweighting.weights import Reweighting
from jaxatt.optimize.root_program import RootProgram
from jaxatt.optimize.solver import solve as solve_one

ROWS, STAGES, SIZE, STARTS = 4, 12, 2, 48
SETTLED = Reweighting(deciding=0, settling=60, settled_smoothing=1e-6)


@functools.partial(jax.jit, static_argnames="shared")
def run(matrix, target, u, free, row_weight, bend, shared, settings):
    """Rows A u - t + bend (A u)^2, for starts u (S, N, b); one matrix (m, N, b) for all."""

    def response(u):
        product = jnp.einsum("mkc,kc->m", matrix, u)
        slope = 1.0 + 2.0 * bend * product
        rows = product - target + bend * product**2
        return rows, jnp.swapaxes(slope[:, None, None] * matrix, 0, 1)

    def one(u, free, weight):
        program = RootProgram(
            free=lambda args: free,
            importance=lambda args: jnp.ones(STAGES),
            row_weight=lambda args: weight,
            response=lambda u, args: response(u),
            limits=lambda args: jnp.eye(SIZE),
            shared=shared,
        )
        return solve_one(CondensedReweighting(settings), program, u, None)

    return jax.vmap(one)(u, free, row_weight)


def problem(seed, size=0.3):
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(ROWS, STAGES, SIZE))
    hidden = np.zeros((STAGES, SIZE))
    active = rng.permutation(STAGES)[:2]
    hidden[active] = rng.uniform(-size, size, (2, SIZE))
    starts = (
        0.003 * rng.normal(size=(STARTS, STAGES, SIZE)) * np.exp(rng.normal(size=(STARTS, 1, 1)))
    )
    return matrix, np.einsum("mkc,kc->m", matrix, hidden), starts


def solve(seed, shared=True, settings=None, bend=0.0, free=None, size=0.3, weight=np.inf):
    matrix, target, starts = problem(seed, size)
    free = np.ones_like(starts) if free is None else free
    rows = np.full((len(starts), ROWS), weight)
    found = run(matrix, target, starts, free, rows, bend, shared, settings or Reweighting())
    return matrix, target, jax.tree.map(np.asarray, found)


def fewest(matrix, target):
    """Least number of stages on which a least-squares solution within limits meets the target."""
    for count in range(STAGES + 1):
        for chosen in itertools.combinations(range(STAGES), count):
            columns = matrix[:, chosen].reshape(ROWS, -1)
            u = np.linalg.lstsq(columns, target, rcond=None)[0] if count else np.zeros(0)
            if np.abs(columns @ u - target).max() < 1e-9 and np.abs(u).max(initial=0.0) <= 1.0:
                return count
    return None


def test_rows_vanish_within_limits_and_mostly_with_the_fewest_stages():
    extra = []
    for seed in range(8):
        matrix, target, found = solve(seed)
        rows = np.einsum("mkc,skc->sm", matrix, found.u) - target
        settled = found.residual < 1e-6
        assert settled.mean() > 0.9
        assert np.abs(rows[settled]).max() < 1e-8
        assert np.abs(found.u).max() <= 1.0 + 1e-12
        counts = (np.abs(found.u).max(axis=2) > 1e-6).sum(axis=1)
        extra.append(counts[settled].min() - fewest(matrix, target))
    # Reweighting is a heuristic, but a good one; brute force knows the truth.
    assert min(extra) == 0 and max(extra) <= 1
    assert sum(more == 0 for more in extra) >= 6


@pytest.mark.parametrize("seed", range(3))
def test_rows_that_bend_vanish_too(seed):
    matrix, target, found = solve(seed, bend=0.1, settings=Reweighting(settling=8))
    product = np.einsum("mkc,skc->sm", matrix, found.u)
    rows = product - target + 0.1 * product**2
    settled = found.residual < 1e-6
    assert settled.any()
    assert np.abs(rows[settled]).max() < 1e-8


def test_a_frozen_support_gets_the_least_sum_of_magnitudes():
    solved = 0
    for seed in range(6):
        rng = np.random.default_rng(100 + seed)
        support = np.zeros((STAGES, 1))
        support[rng.permutation(STAGES)[:5]] = 1.0
        free = np.broadcast_to(support, (STARTS, STAGES, SIZE))
        matrix, target, starts = problem(seed, size=0.2)
        rows = np.full((STARTS, ROWS), np.inf)
        found = run(matrix, target, starts, free, rows, 0.0, False, SETTLED)
        columns = (matrix * support[None]).reshape(ROWS, -1)
        best = scipy.optimize.linprog(
            np.ones(2 * STAGES * SIZE),
            A_eq=np.hstack([columns, -columns]),
            b_eq=target,
            bounds=(0.0, 1.0),
        )
        if best.status == 0:
            effort = np.abs(np.asarray(found.u)).sum(axis=(1, 2))
            np.testing.assert_allclose(effort, best.fun, rtol=2e-3)
            solved += 1
    assert solved >= 3


def test_limits_hold_and_starts_that_they_stop_are_told():
    stopped = 0
    for seed in range(6):
        matrix, target, found = solve(seed, size=2.5, settings=Reweighting(settling=30))
        largest = np.abs(found.u).max(axis=2)
        assert (largest <= 1.0 + 1e-12).all()
        settled = found.residual < 1e-6
        rows = np.einsum("mkc,skc->sm", matrix, found.u) - target
        assert np.abs(rows[settled]).max(initial=0.0) < 1e-6
        on_limit = (largest > 1.0 - 1e-9).any(axis=1)
        np.testing.assert_array_equal(on_limit[found.saturated], True)
        assert found.saturated[~settled].all()
        stopped += int((~settled).sum())
    assert stopped > 0


def test_where_control_is_forbidden_there_is_none():
    free = np.ones((STARTS, STAGES, SIZE))
    free[:, ::3] = 0.0
    _, _, found = solve(2, free=free)
    assert not found.u[:, ::3].any()
    assert not found.support[:, ::3].any()


def test_soft_rows_are_a_compromise():
    matrix, target, hard = solve(3)
    _, _, soft = solve(3, weight=1e-3)
    missed = np.abs(np.einsum("mkc,skc->sm", matrix, soft.u) - target).max(axis=1)
    assert np.median(missed) > 1e-2
    assert np.abs(soft.u).sum() < np.abs(hard.u).sum()


def test_a_start_of_nans_leaves_the_others_as_they_were():
    matrix, target, starts = problem(4)
    rows = np.full((STARTS, ROWS), np.inf)
    free = np.ones_like(starts)
    clean = run(matrix, target, starts, free, rows, 0.0, True, Reweighting())
    starts[7] = np.nan
    spoilt = run(matrix, target, starts, free, rows, 0.0, True, Reweighting())
    others = np.arange(STARTS) != 7
    assert not np.isfinite(np.asarray(spoilt.u[7])).all()
    for a, b in zip(*map(jax.tree.leaves, (spoilt, clean)), strict=True):
        np.testing.assert_array_equal(np.asarray(a)[others], np.asarray(b)[others])
