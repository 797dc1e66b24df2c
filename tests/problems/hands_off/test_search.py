"""Lanes of a batch do not know of each other, and candidates are ordered as promised."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.multistart.driver import run_starts
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.status import Status
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.batch import Form, broadcast_lanes
from jaxatt.problems.hands_off.search.candidates import (
    Candidates,
    better,
    evaluate,
    join,
    support_of,
)
from jaxatt.problems.hands_off.search.polish import HOMOTOPY, POLISH
from jaxatt.problems.hands_off.search.search import search
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.problems.verdict import Verdict


@pytest.fixture(scope="module")
def task():
    return build_slew(scenarios.load("hypso1-90-45-15"))


@pytest.fixture(scope="module")
def lanes(task):
    starts = draw(0, 12, task.intervals, task.size, 0.2)
    free = np.ones_like(starts.u)
    rows = np.full((12, task.rows), np.inf)
    return broadcast_lanes(starts.u, free, rows, starts.sign)


def run(task, lanes, schedule=HOMOTOPY, rows=64, **options):
    form = Form(task.system, task.shared, "sparse", task.size)
    solver = AugmentedLagrangian(schedule)
    return run_starts(solver, form, lanes, task.arguments, rows=rows, **options)


@pytest.fixture(scope="module")
def solved(task, lanes):
    return run(task, lanes)


def some(lanes, rows):
    return jax.tree.map(lambda leaf: leaf[rows], lanes)


def test_a_lane_does_not_depend_on_its_neighbours(task, lanes, solved):
    rows = np.array([7, 2, 11])
    alone = run(task, some(lanes, rows))
    for a, b in zip(jax.tree.leaves(alone), jax.tree.leaves(solved), strict=True):
        np.testing.assert_array_equal(a, b[rows])


def test_more_lanes_than_a_chunk_are_the_same_lanes(task, lanes, solved):
    rows = np.arange(70) % 12
    many = run(task, some(lanes, rows))
    np.testing.assert_array_equal(many.x, solved.x[rows])
    np.testing.assert_array_equal(many.status, solved.status[rows])


def test_a_lane_of_nans_leaves_the_others_alone(task, lanes, solved):
    spoilt = lanes._replace(u=lanes.u.copy())
    spoilt.u[4] = np.nan
    found = run(task, spoilt)
    assert found.status[4] == Status.NOT_FINITE
    others = np.arange(12) != 4
    for a, b in zip(jax.tree.leaves(found), jax.tree.leaves(solved), strict=True):
        np.testing.assert_array_equal(a[others], b[others])
    candidates = evaluate(task, found.x, found.status, found.iterations, lanes.sign)
    assert candidates.status[4] == Status.NOT_FINITE
    assert not candidates.verdict.reached[4]
    assert np.isfinite(candidates.controls).all()


def test_starts_that_make_room_end_as_if_they_had_not(task, lanes):
    supports = np.zeros_like(lanes.free)
    for row in supports:
        row[np.random.default_rng(int(row.shape[0])).permutation(50)[:3]] = 1.0
    frozen = lanes._replace(u=0.3 * lanes.u * supports, free=supports)
    schedule = replace(POLISH, max_iterations=40)
    refilled = run(task, some(frozen, np.arange(40) % 12), schedule, rows=16)
    alone = run(task, frozen, schedule, rows=16)
    assert (alone.iterations > 16).any() and (alone.iterations < 16).any()
    for a, b in zip(*map(jax.tree.leaves, (refilled, alone)), strict=True):
        np.testing.assert_array_equal(a, b[np.arange(40) % 12])


def test_progress_counts_every_lane_once(task, lanes):
    done = []
    run(task, some(lanes, np.arange(70) % 12), progress=done.append)
    assert done[0] == 0 and sum(done) == 70


def test_seeds_reproduce_and_more_starts_keep_the_first(task):
    few, again, many = (search(task, count, seed=3) for count in (5, 5, 16))
    for name in ("controls", "status", "rank", "iterations", "sign"):
        first = getattr(few.starts, name)
        np.testing.assert_array_equal(first, getattr(again.starts, name))
        # A chunk of another size is another program, which may round differently.
        np.testing.assert_allclose(first, getattr(many.starts, name)[:5], rtol=1e-9, atol=1e-15)
    np.testing.assert_array_equal(few.best.controls, again.best.controls)
    other = search(task, 5, seed=4)
    assert (other.starts.controls != few.starts.controls).any()


def test_the_best_is_no_worse_than_any_start(task):
    found = search(task, 16, seed=5)
    reached = found.starts.verdict.reached
    assert reached.any() and found.reaching is not None
    best, starts = found.best.rank[0], found.starts.rank[reached]
    for rank in starts:
        assert tuple(best) <= tuple(rank * (1 + 1e-9))
    supports = {support_of(task, c).tobytes() for c in found.starts.controls[reached]}
    assert 1 <= found.distinct_minima <= reached.sum()
    assert found.distinct_minima >= len(supports)


def test_better_is_lexicographic_beyond_rounding():
    assert better(np.array([1.0, 5.0, 5.0]), np.array([2.0, 0.0, 0.0]))
    assert better(np.array([1.0 + 1e-9, 2.0, 5.0]), np.array([1.0, 3.0, 0.0]))
    assert not better(np.array([1.0, 2.0, 3.0 - 1e-9]), np.array([1.0, 2.0, 3.0]))
    assert not better(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 2.9]))


def verdict(errors, limits=None):
    errors = np.asarray(errors, float)
    limits = np.zeros_like(errors) if limits is None else np.asarray(limits, float)
    return Verdict({"state": errors}, {"state": 1.0}, limits, np.zeros_like(errors))


def candidates(ranks, errors, limits=None):
    ranks = np.asarray(ranks, float)
    count = len(ranks)
    return Candidates(
        np.arange(count, dtype=float).reshape(count, 1, 1),
        np.zeros(count, int),
        verdict(errors, limits),
        ranks,
        np.zeros(count, int),
        np.ones(count),
    )


def test_order_is_reached_first_then_lexicographic():
    rng = np.random.default_rng(0)
    for _ in range(50):
        ranks = rng.integers(0, 3, (8, 3)).astype(float)
        errors = rng.choice([0.5, 0.9, 2.0, 7.0], 8)
        pool = candidates(ranks, errors)
        missed = np.where(errors <= 1.0, 0.0, errors)
        for first in (True, False):
            key = [((missed[i],) if first else ()) + tuple(ranks[i]) for i in range(8)]
            order = pool.order(first)
            assert [key[i] for i in order] == sorted(key)
            assert sorted(order) == list(range(8))


def test_what_breaks_a_limit_or_is_no_number_comes_last():
    pool = candidates([[1, 1, 1]] * 4, [0.5, np.nan, 3.0, 0.1], [0.0, 0.0, 0.0, 1e-6])
    assert list(pool.verdict.reached) == [True, False, False, False]
    order = list(pool.order(True))
    assert order[0] == 0
    assert order[-1] == 1


def test_pick_and_join_keep_rows_together():
    pool = candidates(np.arange(12).reshape(4, 3), [0.1, 2.0, 0.3, 4.0])
    again = join(pool.pick(np.array([2, 0])), pool.pick(3))
    np.testing.assert_array_equal(again.controls[:, 0, 0], [2, 0, 3])
    np.testing.assert_array_equal(again.rank[:, 0], [6, 0, 9])
    np.testing.assert_array_equal(again.verdict.errors["state"], [0.3, 0.1, 4.0])
