"""The batched driver: what a start does depends on itself alone, whoever runs beside it."""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.multistart import driver
from jaxatt.multistart.driver import Plain, run_starts
from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.program import Program
from jaxatt.optimize.solver import Solver, solve
from jaxatt.optimize.status import Status


@dataclass(frozen=True)
class Target:
    """A programme of no solver but the one below."""

    features = frozenset({"a target"})


class Walk(NamedTuple):
    x: jax.Array
    passes: jax.Array


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Halving(Solver):
    """Halves the distance to a target, args, until it is less than a tolerance."""

    tolerance: float = 1e-3

    name = "halving"
    supports = frozenset({"a target"})
    passes = 3

    def init(self, program, start, args):
        return Walk(start - args, jnp.asarray(0))

    def step(self, program, state, args):
        return Walk(0.5 * state.x, state.passes + 1)

    def done(self, state):
        return ~(jnp.max(jnp.abs(state.x)) > self.tolerance)

    def result(self, program, state, args):
        return {"x": state.x + args, "passes": state.passes}


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class FirstAxis(Halving):
    batch_axis = 0


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Tenfold(Halving):
    """As many passes for every start."""

    same_passes = True

    def done(self, state):
        return state.passes >= 10


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Branching(Tenfold):
    """The last passes are others."""

    def step(self, program, state, args):
        x = jax.lax.cond(state.passes < 8, lambda x: 0.5 * x, lambda x: 0.1 * x, state.x)
        return Walk(x, state.passes + 1)


SOLVERS = [Halving(), FirstAxis(), Tenfold()]
TARGET = np.array([0.25, -1.0])


def drawn(count, seed=0):
    rng = np.random.default_rng(seed)
    return TARGET + rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-5.0, 6.0, (count, 1))


def run(solver, starts, **options):
    return run_starts(solver, Plain(Target()), starts, TARGET, **options)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize(("count", "rows"), [(1, 8), (7, 4), (8, 8), (37, 8), (37, 64)])
def test_a_start_ends_as_if_alone_whatever_the_chunk(solver, count, rows):
    starts, told = drawn(count), []
    found = run(solver, starts, rows=rows, progress=told.append)
    alone = [solve(solver, Target(), jnp.asarray(start), TARGET) for start in starts]
    np.testing.assert_array_equal(found["x"], [one["x"] for one in alone])
    np.testing.assert_array_equal(found["passes"], [one["passes"] for one in alone])
    assert told[0] == 0 and sum(told) == count
    if not solver.same_passes and count > 8:
        assert found["passes"].min() < solver.passes < found["passes"].max()


def test_a_branch_on_a_count_that_all_starts_share_stays_one():
    """Otherwise both sides are computed for every start, in every pass."""
    job = driver.Job(Plain(Target()), False, None)
    traced = jax.make_jaxpr(driver.to_the_end._function, static_argnums=0)(
        job, drawn(8), TARGET, Branching()
    )
    assert "cond[" in str(traced)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_a_start_that_is_not_a_number_spoils_nobody(solver):
    starts = drawn(21)
    spoilt = starts.copy()
    spoilt[[0, 13]] = np.nan
    found, clean = run(solver, spoilt, rows=8), run(solver, starts, rows=8)
    others = np.isfinite(spoilt).all(axis=1)
    assert np.isnan(found["x"][~others]).all()
    for a, b in zip(*map(jax.tree.leaves, (found, clean)), strict=True):
        np.testing.assert_array_equal(a[others], b[others])


def test_another_tolerance_compiles_nothing():
    starts = drawn(9)
    run(Halving(), starts, rows=8)
    before = driver.some_passes._jitted._cache_size()
    closer = run(Halving(1e-9), starts, rows=8)
    assert driver.some_passes._jitted._cache_size() == before
    assert np.abs(closer["x"] - TARGET).max() <= 1e-9


def test_chunks_shrink_to_what_fits_into_memory(monkeypatch):
    one = 2 * 8 + 8
    monkeypatch.setattr(driver, "_CPU_BYTES", 5 * driver._WORKING_COPIES * one)
    starts, chunks = drawn(30), []

    def seen(advance, lanes, empty, rows, *rest):
        chunks.append(rows)
        return refilling(advance, lanes, empty, rows, *rest)

    refilling = driver.refilling
    monkeypatch.setattr(driver, "refilling", seen)
    found = run(Halving(), starts, rows=64)
    assert chunks == [4 * jax.local_device_count()]
    np.testing.assert_array_equal(found["x"], run(Halving(), starts, rows=2)["x"])


CIRCLE = Program(
    objective=lambda x, a, s: jnp.sum((x - a[None]) ** 2),
    curvature=lambda x, a, s: 2.0 * jnp.eye(2)[None],
    equality=lambda x, a: (jnp.sum(x**2) - 1.0)[None],
)


def test_solves_that_make_room_end_like_those_that_need_not():
    rng = np.random.default_rng(4)
    starts = rng.normal(size=(30, 1, 2))
    starts[5] = np.nan
    solver, target = AugmentedLagrangian(Schedule(penalty=10.0)), jnp.array([2.0, 1.0])
    found = run_starts(solver, Plain(CIRCLE), starts, target, rows=8)
    order = rng.permutation(30)
    moved = run_starts(solver, Plain(CIRCLE), starts[order], target, rows=8)
    for a, b in zip(*map(jax.tree.leaves, (found, moved)), strict=True):
        np.testing.assert_array_equal(a[order], b)
    assert found.status[5] == Status.NOT_FINITE
    converged = found.status == Status.CONVERGED
    assert converged.sum() >= 20
    nearest = np.array([2.0, 1.0]) / np.sqrt(5.0)
    ends = np.abs(found.x[converged, 0])
    np.testing.assert_allclose(ends, np.broadcast_to(nearest, ends.shape), atol=1e-5)
