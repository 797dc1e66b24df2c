"""Supports decided by reweighted steps: how many starts are useful, and what limits do to them."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.polish import Method, decide, screen
from jaxatt.problems.hands_off.search.starts import draw

METHOD = Method("l0", rows=32)


def task_with(share, name="hypso1-90-45-15"):
    scenario = scenarios.load(name)
    limit = share * np.asarray(scenario.vehicle.wheels.torque_limit)
    return build_slew(
        scenarios.replace(scenario, {"vehicle.wheels.torque_limit_Nm": limit.tolist()})
    )


def decided(task, seed, count=64):
    starts = draw(seed, count, task.intervals, task.size, task.long_way_probability())
    u, supports = decide(task, starts, METHOD)
    controls = task.to_controls(u * supports)
    return controls, task.verify(controls)[0]


@pytest.mark.parametrize(
    ("share", "least"), [(1.0, 0.95), (0.5, 0.8), (0.35, 0.7)], ids="{} of the limit".format
)
def test_most_starts_find_two_intervals_even_where_torque_is_scarce(share, least):
    task = task_with(share)
    controls, verdict = decided(task, seed=11)
    active = (np.abs(controls).max(axis=2) > 0.0).sum(axis=1)
    useful = verdict.reached & (active == 2)
    assert useful.mean() >= least
    relative = np.abs(task.wheel_torque(controls)) / np.asarray(task.craft.wheels.torque_limit)
    assert relative.max() <= 1.0 + 1e-12


def test_starts_differ_and_some_go_the_long_way():
    task = task_with(1.0)
    controls, verdict = decided(task, seed=12)
    supports = {(np.abs(c).max(axis=1) > 0.0).tobytes() for c in controls[verdict.reached]}
    assert len(supports) >= 8


def test_screening_tells_supports_that_reach_from_those_that_do_not():
    task = task_with(1.0)
    far, near = np.zeros((2, task.intervals, 1), bool)
    far[[3, 40]] = True
    near[[20, 24]] = True
    masks = np.stack([far, near])
    rest = np.zeros((2, task.intervals, task.size))
    found = screen(task, rest, masks, np.ones(2), METHOD)
    np.testing.assert_array_equal(found.verdict.reached, [True, False])
