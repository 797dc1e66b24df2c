"""Minimum time with wheels that must not enter a band around zero, or may cross it quickly."""

import functools

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.search import search_free_time

EDGE = 20.0


@functools.cache
def turned(stay=None, banded=True):
    """Best turn with a bias of 22 rad/s, its task, and its wheel speeds between the nodes."""
    band = {"to_rad_s": EDGE} | ({} if stay is None else {"leave_within_s": stay})
    task = build_time_task(
        scenarios.from_mapping(
            {
                "name": "banded",
                "vehicle": {"use": "hypso1", "wheels": {"avoid": [band] if banded else []}},
                "initial": {
                    "attitude_deg": [0.0, 0.0, 0.0],
                    "wheel_speed_rad_s": (22.0 * np.array([1.0, 1.0, 1.0, -np.sqrt(3.0)])).tolist(),
                },
                "target": {
                    "axis": [1.0, 1.0, 0.0],
                    "angle_deg": 60.0,
                    "rate_tolerance_rad_s": 1e-4,
                },
                "horizon": {"intervals": 16, "substeps": 2},
                "objective": {"kind": "minimum-time"},
            }
        )
    )
    found = search_free_time(task, 4, 0)
    torque, step = found.controls[found.best][None], found.step[found.best][None]
    return found, np.asarray(task.fly(torque, step, between=61).omega_bw)[0], float(step[0]) / 61


@pytest.mark.slow
def test_wheels_stay_beyond_the_band_and_that_costs_time():
    found, speeds, _ = turned()
    free, crossed, _ = turned(banded=False)
    assert found.reached[found.best] and free.reached[free.best]
    assert np.abs(speeds).min() >= EDGE * (1.0 - 1e-6)
    assert np.abs(crossed).min() < 1.0  # else there was nothing to avoid
    assert found.cost[found.best] > 1.1 * free.cost[free.best]


@pytest.mark.slow
def test_a_band_may_be_crossed_where_that_is_quick_enough():
    free, crossed, step = turned(banded=False)
    longest = max(_runs(np.abs(crossed[:, i]) < EDGE) for i in range(4)) * step
    assert longest > 0.5
    quick, _, _ = turned(1.02 * longest)
    assert quick.reached[quick.best]
    assert quick.cost[quick.best] == pytest.approx(free.cost[free.best], rel=1e-6)
    barred, speeds, step = turned(0.9 * longest)
    assert barred.reached[barred.best]
    inside = np.abs(speeds) < EDGE * (1.0 - 1e-6)
    assert max(_runs(inside[:, i]) for i in range(4)) * step <= 0.9 * longest


def _runs(inside):
    """Longest run of instants inside."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside, [0]]).astype(int)))
    return max(np.diff(edges)[::2], default=0)
