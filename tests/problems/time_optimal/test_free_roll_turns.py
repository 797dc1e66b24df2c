"""Turns in minimum time that point one axis: bounds on paper, IPOPT, and the same with MRP.

The figures of IPOPT are those of `python -m benchmarks.casadi_boresight CASE --axis AXIS`.
"""

import copy

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jaxatt
from jaxatt import scenarios

X, Z = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]


def pointed(name, axis, direction, intervals, **changes):
    """A bundled turn, in minimum time, with a target that points an axis."""
    document = copy.deepcopy(dict(scenarios.load(name).document))
    document["target"] = {
        "align": {"body": list(axis), "direction_inertial": list(direction)},
        "attitude_tolerance_deg": 0.01,
        "rate_tolerance_rad_s": 1e-4,
    }
    document.pop("printed", None)
    document["objective"] = {"kind": "minimum-time"}
    document["horizon"] = {"intervals": intervals}
    document |= changes
    return scenarios.from_mapping(document)


@pytest.fixture(scope="module")
def unit_body():
    """Turns of a body of unit inertia with torques of 1 N m, whose programme compiles once."""

    def fastest(direction):
        return jaxatt.solve(pointed("minimum-time-180", Z, direction, 20), starts=4)

    return fastest


def time_of(result):
    phase = result.phases[0]
    assert phase.reached
    return phase.final_time


def test_a_quarter_turn_of_the_axis_is_within_its_bounds(unit_body):
    result = unit_body(X)
    # No acceleration is larger than sqrt(3), and 120 deg about (1, 1, 1) bring z onto x with it.
    least, most = (2.0 * np.sqrt(angle / np.sqrt(3.0)) for angle in (np.pi / 2, 2 * np.pi / 3))
    about_its_own_axis = 2.0 * np.sqrt(np.pi / 2)
    assert least < time_of(result) < 1.001 * most < about_its_own_axis
    end = result.phases[0].series["q_ob"][-1]
    reached = Rotation.from_quat(end, scalar_first=True).apply(Z)
    np.testing.assert_allclose(reached, X, atol=2e-4)
    np.testing.assert_allclose(result.phases[0].reference["q_ob"], end, atol=2e-4)


@pytest.mark.slow
def test_a_small_turn_takes_the_time_of_its_larger_part(unit_body):
    # To first order the two angles of the axis are double integrators of their own; a roll on the
    # way helps by a share of the angle.
    small = np.random.default_rng(0).uniform(0.002, 0.004, 2)
    direction = Rotation.from_rotvec([*small, 0.0]).apply(Z)
    time = time_of(unit_body(direction.tolist()))
    assert time == pytest.approx(2.0 * np.sqrt(small.max()), rel=2e-3)


def test_what_points_there_already_takes_no_time(unit_body):
    assert time_of(unit_body(Z)) == 0.0


IPOPT = {
    ("mrp-k3", (0.0, 0.0, 1.0)): 16.707033,
    ("mrp-k3-2.5rad", (0.0, 1.0, 0.0)): 35.433144,
}
"""(scenario, body axis) -> least time [s]."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "axis", "attitude"),
    [*((*case, "quaternion") for case in IPOPT), (*next(iter(IPOPT)), "mrp")],
)
def test_the_least_time_is_that_of_ipopt(name, axis, attitude):
    unit = np.array(axis) / np.linalg.norm(axis)
    target = scenarios.load(name).targets[0].q_ob
    direction = Rotation.from_quat(target, scalar_first=True).apply(unit)
    changes = {"transcription": {"attitude": attitude, "integration": "rk4"}}
    result = jaxatt.solve(pointed(name, unit, direction, 30, **changes), starts=4)
    assert time_of(result) == pytest.approx(IPOPT[name, axis], abs=3e-4)
