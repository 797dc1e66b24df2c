"""Wheels near speeds that they must not have: kept between the nodes too, and named where not."""

import numpy as np

from jaxatt import scenarios
from jaxatt.optimize.status import Status
from jaxatt.problems.failure_reason import failure_reason
from jaxatt.problems.time_optimal import search
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.search import search_free_time
from jaxatt.problems.verdict import Verdict
from jaxatt.problems.wheel_speeds import broken_speeds, speed_excess, speed_range
from jaxatt.spacecraft import reaction_wheels

LIMIT = 677.0


def turn_with_little_room(room, angle):
    """A turn about x whose wheel is `room` [rad/s] below its limit at the start."""
    return scenarios.from_mapping(
        {
            "name": "near-the-limit",
            "vehicle": {
                "inertia_kgm2": np.diag([0.03798, 0.03957, 0.00688]).tolist(),
                "wheels": {
                    "axes": np.eye(3).tolist(),
                    "inertia_kgm2": 135.0e-7,
                    "torque_limit_Nm": 1e-3,
                    "speed_limit_rad_s": LIMIT,
                },
            },
            "initial": {
                "attitude_deg": [0.0, 0.0, 0.0],
                "wheel_speed_rad_s": [LIMIT - room, 0.0, 0.0],
            },
            "target": {
                "axis": [1.0, 0.0, 0.0],
                "angle_deg": angle,
                "rate_tolerance_rad_s": 1e-4,
            },
            "horizon": {"intervals": 40, "substeps": 1},
            "objective": {"kind": "minimum-time"},
        }
    )


def test_a_limit_overstepped_between_nodes_is_tightened_and_kept():
    rng = np.random.default_rng(51)
    for room, angle in ((1.0, -30.0), (rng.uniform(0.5, 3.0), rng.uniform(-40.0, -20.0))):
        task = build_time_task(turn_with_little_room(room, angle))
        found = search_free_time(task, 8, 0)
        assert found.reached[found.best]
        torque, step = found.controls[found.best][None], found.step[found.best][None]
        speeds = np.abs(task.fly(torque, step, between=37).omega_bw)
        assert speeds.max() <= LIMIT * (1.0 + 1e-6)


def test_without_a_second_solve_that_answer_would_be_refused(monkeypatch):
    monkeypatch.setattr(search, "_MOST_TIGHTENINGS", 0)
    task = build_time_task(turn_with_little_room(1.0, -30.0))
    found = search_free_time(task, 8, 0)
    cheapest = int(np.argmin(found.cost))
    assert found.verdict.arrives[cheapest] and not found.reached[cheapest]


def test_a_wheel_at_its_limit_from_the_start_is_not_tightened_out_of_reach():
    wheels = reaction_wheels(np.eye(3), 1e-5, 1e-3, speed_limit=LIMIT)
    lower, upper = speed_range(wheels, np.array([LIMIT, 0.0, -LIMIT]), np.full(3, 1e-3))
    np.testing.assert_allclose(upper, [LIMIT, 0.999 * LIMIT, 0.999 * LIMIT])
    np.testing.assert_allclose(lower, [-0.999 * LIMIT, -0.999 * LIMIT, -LIMIT])


def test_the_wheel_is_named():
    wheels = reaction_wheels(np.eye(3), 1e-5, 1e-3, speed_limit=[100.0, np.inf, 200.0])
    speeds = np.array([[[90.0, 1e6, 0.0], [-95.0, 0.0, 201.0]]])
    excess = speed_excess(wheels, speeds)
    np.testing.assert_allclose(excess, [[-0.05, -1.0, 0.005]])
    words = broken_speeds(wheels, speeds[0], 1.0)
    assert words == ["wheel 3 turns 0.5 % faster than its limit of 200 rad/s"]
    verdict = Verdict({}, {}, np.zeros(1), excess.max(axis=1))
    said = failure_reason(verdict, Status.CONVERGED, broken_margins=words)
    assert said == words[0]
    assert "path constraint" in failure_reason(verdict, Status.CONVERGED)
