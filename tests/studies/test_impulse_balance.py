"""The lower bound on open time: exact for a single axis, never beaten."""

import math

import numpy as np
import pytest

from jaxatt.spacecraft import create, thrusters
from jaxatt.studies.impulse_balance import (
    eigenaxis_on_time,
    largest_torque,
    least_intervals,
    least_on_time,
)

PAIRS = np.concatenate([np.eye(3), -np.eye(3)], axis=1)


def test_largest_torque_is_that_of_a_corner() -> None:
    craft = create(np.eye(3), None, thrusters=thrusters(PAIRS, 0.2))
    assert largest_torque(craft) == pytest.approx(0.2 * math.sqrt(3.0))


@pytest.mark.parametrize("seed", range(5))
def test_single_axis_open_time_is_the_analytic_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    inertia, limit, duration = rng.uniform(1.0, 5.0), rng.uniform(0.05, 0.5), rng.uniform(20.0, 60)
    craft = create(np.eye(3) * inertia, None, thrusters=thrusters(PAIRS, limit))
    angle = rng.uniform(0.05, 0.9) * limit / inertia * duration**2 / 4.0
    turn = np.array([0.0, angle, 0.0])
    expected = duration - math.sqrt(duration**2 - 4.0 * angle * inertia / limit)
    assert eigenaxis_on_time(craft, turn, duration) == pytest.approx(expected)
    assert least_on_time(craft, turn, duration) <= expected


def test_turns_beyond_reach_need_more_than_there_is() -> None:
    craft = create(np.eye(3), None, thrusters=thrusters(PAIRS, 1e-3))
    turn = np.array([3.0, 0.0, 0.0])
    assert least_on_time(craft, turn, 10.0) == math.inf
    assert least_intervals(craft, turn, 10.0, 0.5) == 21
