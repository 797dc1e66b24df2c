"""Slews with a failed wheel, beside CasADi with IPOPT."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jaxatt
from jaxatt import scenarios

FAILED = "vehicle.wheels.failed"


def turn_of(case, target, begin, end):
    from references.ipopt_turns import Turn

    craft = case.vehicle
    return Turn(
        np.asarray(craft.wheels.axes),
        float(craft.wheels.torque_limit[0]),
        np.asarray(craft.inertia),
        np.asarray(craft.inertia_without_spin),
        target,
        begin,
        end,
        case.horizon.intervals,
    )


def test_a_failed_wheel_may_not_turn():
    case = scenarios.load("hypso1-90-45-15-failed-wheel")
    speeds = [10.0, 0.0, -20.0, 30.0]
    moved = scenarios.replace(case, {"initial.wheel_speed_rad_s": speeds})
    np.testing.assert_array_equal(moved.initial.omega_bw, [10.0, -20.0, 30.0])
    with pytest.raises(scenarios.ScenarioError, match="wheel 2 has failed"):
        scenarios.replace(case, {"initial.wheel_speed_rad_s": [0.0, 1.0, 0.0, 0.0]})
    for change in ({FAILED: ["wheel 5"]}, {FAILED: "wheel 2"}, {FAILED: ["wheel 1", "wheel 2"]}):
        with pytest.raises(scenarios.ScenarioError, match=r"\[vehicle.wheels\] failed"):
            scenarios.replace(case, change)


def test_a_flight_by_feedback_has_no_failed_wheel():
    flight = scenarios.load_flight("microsatellite-rest-to-rest")
    axes = [*np.eye(3).tolist(), [0.6, 0.48, 0.64]]
    changes = {"vehicle.wheels.axes": axes, FAILED: ["wheel 2"], "simulation.duration_s": 20.0}
    left = scenarios.replace_in_flight(flight, changes)
    result = jaxatt.simulate(left)
    assert result.sound.all()
    assert any("wheel 2 has failed" in note for note in left.notes)
    archive = result.to_dataset()
    assert list(archive.wheel.values) == [1, 3, 4]
    assert list(archive.wheel_name.values) == ["wheel 1", "wheel 3", "wheel 4"]


@pytest.mark.slow
def test_earning_with_a_wheel_failed_is_earning_without_it():
    case = scenarios.load("hypso1-netpower")
    more = {
        "vehicle.wheels.axes": [*np.eye(3).tolist(), [0.6, 0.48, 0.64]],
        "initial.wheel_speed_rad_s": [0.0] * 4,
        FAILED: ["wheel 4"],
    }
    without, failed = (
        jaxatt.solve(one, starts=2).phases[0] for one in (case, scenarios.replace(case, more))
    )
    np.testing.assert_array_equal(failed.series["torque_wheels"], without.series["torque_wheels"])
    assert failed.section.energy.net == without.section.energy.net


@pytest.fixture(scope="module")
def circular():
    case = scenarios.load("hypso1-90-45-15-failed-wheel")
    return jaxatt.solve(scenarios.replace(case, {"orbit.eccentricity": 0.0}), starts=32)


def test_the_slew_reaches_and_names_its_wheels(circular):
    assert circular.reached
    assert circular.phases[0].active_intervals == 2  # one would leave the rate that it has made
    archive = circular.to_dataset()
    assert list(archive.wheel.values) == [1, 3, 4]
    assert archive.wheel.attrs["failed"] == "wheel 2"
    assert archive.torque_wheels.shape[1] == 3


@pytest.mark.slow
def test_its_effort_is_that_of_ipopt(circular):
    pytest.importorskip("casadi")
    from references.ipopt_turns import least_effort

    phase, case = circular.phases[0], circular.scenario
    # The orbit frame turns about its own negative y axis; by how much until the end, follows.
    orbit, target = case.orbit, case.targets[0].q_ob
    rate = np.sqrt(orbit.gravitational_parameter / orbit.semi_major_axis**3)
    half = -0.5 * rate * case.horizon.duration
    carried = Rotation.from_quat([0.0, np.sin(half), 0.0, np.cos(half)])
    body = Rotation.from_quat(target, scalar_first=True)
    begin = np.array([0.0, -rate, 0.0])
    turn = turn_of(
        case, (carried * body).as_quat(scalar_first=True), begin, body.inv().apply(begin)
    )
    found = least_effort(turn, case.horizon.step, np.flatnonzero(phase.active).tolist())
    assert phase.l1_effort == pytest.approx(found, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("failed", [1, 2, 3, 4])
def test_the_time_with_any_one_of_four_wheels_failed_is_that_of_ipopt(failed):
    pytest.importorskip("casadi")
    from references.ipopt_turns import least_cost

    case = scenarios.replace(scenarios.load("mrp-k4-rk4"), {FAILED: [f"wheel {failed}"]})
    result = jaxatt.solve(case, starts=8)
    phase = result.phases[0]
    assert result.reached
    turn = turn_of(case, case.targets[0].q_ob, np.zeros(3), np.zeros(3))
    cost, time = least_cost(turn, case.objective.effort_weight, 27.0)
    assert phase.section.cost == pytest.approx(cost, rel=1e-6)
    assert phase.final_time == pytest.approx(time, rel=1e-5)
    assert list(phase.section.actuators) == [f"wheel {i}" for i in range(1, 5) if i != failed]
