"""Starts of the double integrator end with the fewest intervals that the least effort allows."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import linprog

from jaxatt import scenarios
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.elimination import with_fewer_intervals
from jaxatt.problems.hands_off.search.polish import Method, decide, polish
from jaxatt.problems.hands_off.search.search import look
from jaxatt.problems.hands_off.search.starts import draw
from jaxatt.problems.toy.build import build_toy

STARTS = 16
PUBLISHED = 38
"""Of 0.05 s, 29 one way and 9 the other: the least effort is 1.837722 s, the impulse -1 s."""


def task_of(**changes):
    return build_toy(scenarios.replace(scenarios.load("double-integrator"), changes))


def counts(task, found):
    return np.array([support_of(task, controls).sum() for controls in found.controls])


def least_effort(state, limit, task):
    """Fewest intervals that the least effort fills, and those of its vertex; None out of reach."""
    n, h = task.intervals, task.step
    pushes = np.stack([h * h * (n - np.arange(n) - 0.5), np.full(n, h)])
    drift = np.array([state[0] + n * h * state[1], state[1]])
    answer = linprog(
        np.ones(2 * n),
        A_eq=np.hstack([pushes, -pushes]),
        b_eq=-drift,
        bounds=[(0.0, limit)] * (2 * n),
        method="highs-ds",
    )
    if answer.status:
        return None
    return int(np.ceil(answer.fun / limit - 1e-9)), int((answer.x > 1e-9).sum())


@pytest.mark.parametrize("seed", range(5))
def test_most_starts_of_the_published_case_are_useful(seed):
    task = task_of()
    found = look(task, STARTS, seed)
    assert (found.verdict.reached & (counts(task, found) <= PUBLISHED)).mean() >= 0.8


def test_most_starts_are_useful_from_any_state_and_with_any_limit():
    rng, useful, fewest = np.random.default_rng(1604), [], []
    while len(useful) < 10:
        state, limit = rng.normal(size=2) * [2.0, 1.0], 10.0 ** rng.uniform(-0.3, 1.0)
        task = task_of(**{"initial.state": state.tolist(), "control.limit": float(limit)})
        bounds = least_effort(state, limit, task)
        if bounds is None:
            continue
        found = look(task, STARTS, 0)
        assert found.verdict.reached.all()
        number = counts(task, found)
        # The vertex has at most one interval more than the effort fills.
        assert number.min() >= bounds[0] and number.min() <= bounds[1]
        useful.append((number <= bounds[1]).mean())
        fewest.append(bounds[1])
    assert np.mean(useful) >= 0.9 and np.min(useful) >= 0.5
    assert len(set(fewest)) > 5


def test_leaving_out_makes_no_start_worse():
    """With intervals that cost less than others, and with some that are forbidden."""
    windows = [
        {"start_s": 0.0, "end_s": 1.0, "weight": 0.0},
        {"start_s": 1.0, "end_s": 1.2, "weight": 0.01},
        {"start_s": 4.0, "end_s": 4.3, "forbidden": True},
    ]
    task = task_of(windows=windows, **{"objective.kind": "moving-l0"})
    method = Method("l0", rows=STARTS)
    starts = draw(3, STARTS, task.intervals, 1, 0.0)
    u, supports = decide(task, starts, method)
    before = polish(task, u, supports, starts.sign, method)
    after = with_fewer_intervals(task, before, method)
    assert (after.verdict.reached >= before.verdict.reached).all()
    kept = before.verdict.reached
    assert (after.rank[kept, 0] <= before.rank[kept, 0] + 1e-9).all()
    assert (after.rank[kept, 0] < before.rank[kept, 0] - 0.5).any()
    forbidden = np.asarray(task.arguments.free)[:, 0] == 0.0
    assert forbidden.any() and not np.abs(after.controls[:, forbidden]).any()
    assert jnp.isfinite(after.controls).all()
