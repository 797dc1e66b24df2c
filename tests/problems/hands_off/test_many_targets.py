"""Slews to many targets in one batch: as good as one by one, and flown by SciPy."""

from dataclasses import replace

import numpy as np
import pytest
from references import wheeled_body
from references.reflight import body_of, space_of

from jaxatt import scenarios, solve
from jaxatt.attitude import quaternion
from jaxatt.attitude.uniform_rotations import uniform_rotations
from jaxatt.problems.registry import family_of

INTERVALS = 20
STARTS = 4


def slew(**changes):
    settings = {
        "horizon.intervals": INTERVALS,
        "horizon.coast_intervals": 0,
        "windows": None,
        "solver.starts": STARTS,
    }
    return scenarios.replace(scenarios.load("hypso1-90-45-15"), settings | changes)


def targets(seed, count):
    """Random attitudes, and the hard ones: half turns, and one that is almost the initial."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(count, 4))
    q[0] = [0.0, 1.0, 0.0, 0.0]
    q[1] = [1e-9, *rng.normal(size=3)]
    q[2] = [1.0, *(2e-3 * rng.normal(size=3))]
    q[3] = -np.abs(q[3])
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def ends(scenario, found, k):
    """Angle [rad] and rate [rad/s] by which SciPy's flight of an answer misses."""
    initial = scenario.initial
    torque = found.controls[k] @ np.linalg.pinv(np.asarray(scenario.vehicle.wheels.axes)).T
    flight = wheeled_body.fly(
        body_of(scenario),
        space_of(scenario),
        initial.q_ob,
        initial.omega_ob,
        initial.omega_bw,
        torque,
        float(found.step[k]),
        0.0,
    )
    limit = np.asarray(scenario.vehicle.wheels.torque_limit)
    assert (np.abs(torque) <= limit * (1.0 + 1e-9)).all()
    return flight.q[-1], flight.relative[-1]


@pytest.fixture(scope="module")
def free():
    """A slew that no limit stands in the way of, and answers to its targets."""
    scenario, aimed = slew(), targets(1, 40)
    return scenario, aimed, family_of(scenario).answer_targets(scenario, aimed)


@pytest.fixture(scope="module")
def tight():
    """The same with torque limits that bind for most."""
    scenario = slew(**{"vehicle.wheels.torque_limit_Nm": 8e-4})
    aimed = targets(2, 24)
    return scenario, aimed, family_of(scenario).answer_targets(scenario, aimed)


def test_two_intervals_reach_every_target_without_limits(free):
    _, _, found = free
    assert found.reached.all()
    assert (found.numbers["active_intervals"] == 2.0).all()


@pytest.mark.parametrize("case", ["free", "tight"])
def test_scipy_flies_every_answer_to_its_target(case, request):
    scenario, aimed, found = request.getfixturevalue(case)
    assert found.reached.sum() >= 20
    for k in np.flatnonzero(found.reached):
        q, rate = ends(scenario, found, k)
        assert np.degrees(wheeled_body.angle_between(q, aimed[k])) < 0.01
        assert np.linalg.norm(rate) < 1e-5
        assert found.numbers["flight_error_deg"][k] < 1e-3
        active = np.abs(found.controls[k]).max(axis=1) > 0.0
        assert active.sum() == found.numbers["active_intervals"][k]


def test_no_more_intervals_and_effort_than_one_by_one(free, tight):
    rng = np.random.default_rng(3)
    for scenario, aimed, found in (free, tight):
        for k in rng.choice(len(aimed), 2, replace=False):
            one = replace(scenario, targets=(replace(scenario.targets[0], q_ob=aimed[k]),))
            phase = solve(one).phases[0]
            assert found.reached[k] >= phase.reached
            if not phase.reached:
                continue
            count = found.numbers["active_intervals"][k]
            assert count <= phase.active_intervals
            if count == phase.active_intervals == 2:
                assert found.numbers["l1_effort_Nms"][k] <= phase.l1_effort * (1.0 + 1e-4)


def test_targets_out_of_reach_are_said_and_spoil_no_other(free):
    scenario = slew(**{"vehicle.wheels.torque_limit_Nm": 4e-5})
    aimed = targets(4, 6)
    aimed[3:] = np.asarray(quaternion.multiply([0.0, 1.0, 0.0, 0.0], aimed[3:]))
    found = family_of(scenario).answer_targets(scenario, aimed)
    assert found.reached[2]
    assert not found.reached.all()
    assert np.isnan(found.numbers["active_intervals"][~found.reached]).all()
    assert np.isfinite(found.numbers["attitude_error_deg"]).all()


def test_hardly_any_intervals_are_no_obstacle_to_say_so():
    scenario = slew(**{"horizon.intervals": 2, "vehicle.wheels.torque_limit_Nm": 4e-5})
    found = family_of(scenario).answer_targets(scenario, targets(6, 4))
    assert not found.reached[[0, 1, 3]].any()


def test_answers_do_not_depend_on_their_neighbours(free):
    scenario, aimed, found = free
    some = np.array([7, 2, 0])
    again = family_of(scenario).answer_targets(scenario, aimed[some])
    np.testing.assert_allclose(again.controls, found.controls[some], rtol=0, atol=1e-12)


def test_spread_targets_are_uniform():
    q = uniform_rotations(4000)
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-12)
    # Of uniform rotations, q q' is a quarter of the identity in the mean, and the angle's share
    # below t is (t - sin t) / pi.
    np.testing.assert_allclose(q.T @ q / len(q), 0.25 * np.eye(4), atol=2e-3)
    angle = np.sort(2.0 * np.arccos(np.clip(q[:, 0], -1.0, 1.0)))
    share = (np.arange(len(q)) + 0.5) / len(q)
    assert np.abs((angle - np.sin(angle)) / np.pi - share).max() < 5e-3
