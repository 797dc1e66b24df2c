"""Turns to many targets in one batch: the times of turns one by one."""

from dataclasses import replace

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.problems.registry import family_of
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.search import search_free_time

STARTS = 4


def turn(name, **changes):
    settings = {"solver.starts": STARTS, "horizon.intervals": 20}
    return scenarios.replace(scenarios.load(name), settings | changes)


@pytest.fixture(scope="module")
def wheels():
    """Minimum time with four wheels; targets with half a turn and a small one among them."""
    scenario = turn("mrp-k4-rk4", **{"objective.kind": "minimum-time"})
    rng = np.random.default_rng(11)
    q = rng.normal(size=(10, 4))
    q[0], q[1] = [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.02, 0.01]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return scenario, q, family_of(scenario).answer_targets(scenario, q)


def test_every_target_is_reached_in_the_time_of_its_own_solve(wheels):
    scenario, q, found = wheels
    assert found.reached.all()
    assert found.numbers["kkt.stationarity"].max() < 1e-6
    assert found.numbers["kkt.violation"].max() < 1e-6
    for k in (0, 7):
        one = replace(scenario, targets=(replace(scenario.targets[0], q_ob=q[k]),))
        alone = search_free_time(build_time_task(one), STARTS, one.solver.seed)
        time = found.numbers["final_time_s"][k]
        assert time == pytest.approx(alone.cost[alone.best], rel=1e-6)


@pytest.mark.slow
def test_a_half_turn_takes_its_published_time():
    scenario = turn("minimum-time-180", **{"horizon.intervals": 60, "solver.starts": 16})
    q = np.concatenate([[np.zeros(3)], np.eye(3)]).T
    found = family_of(scenario).answer_targets(scenario, q)
    assert found.reached.all()
    # Bilimoria and Wie (1993): 3.2431 s about any axis of a sphere.
    np.testing.assert_allclose(found.numbers["final_time_s"], 3.2431, rtol=1e-3)


def test_errors_of_flights_are_of_each_answer(wheels):
    _, _, found = wheels
    assert (found.numbers["flight_error_deg"] < 1e-3).all()
    assert (found.numbers["attitude_error_deg"] < 0.01).all()
