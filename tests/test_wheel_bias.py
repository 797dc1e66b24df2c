"""Wheel speeds at the end in the null space of the mounting, judged by the flight."""

import numpy as np
import pytest

import jaxatt
from jaxatt import scenarios
from jaxatt.spacecraft.wheel_bias import bias_of, null_momenta, unit_bias

BIAS = "target.wheel_bias_rad_s"
NULL = np.array([1.0, 1.0, 1.0, -np.sqrt(3.0)]) / np.sqrt(6.0)


def biased(bias, **changes):
    return scenarios.replace(
        scenarios.load("hypso1-90-45-15"), {BIAS: bias, "solver.starts": 16, **changes}
    )


def test_the_bias_stores_no_momentum_and_leaves_the_least_of_the_others():
    rng = np.random.default_rng(11)
    from references.random_vehicles import wheel_axes

    from jaxatt.spacecraft import reaction_wheels

    for count in (4, 5, 6):
        wheels = reaction_wheels(wheel_axes(rng, count), rng.uniform(1e-4, 3e-4, count), 1e-3)
        speeds = rng.normal(size=count)
        bias = bias_of(wheels, speeds)
        np.testing.assert_allclose(wheels.axes @ (wheels.inertia * bias), 0.0, atol=1e-17)
        rest = wheels.inertia * (speeds - bias)
        np.testing.assert_allclose(null_momenta(wheels).T @ rest, 0.0, atol=1e-17)
        np.testing.assert_allclose(bias_of(wheels, bias), bias, atol=1e-13)
    np.testing.assert_allclose(unit_bias(biased(1.0).vehicle.wheels), NULL, atol=1e-12)


def test_a_number_a_list_and_what_is_refused():
    wanted = 30.0 * NULL
    np.testing.assert_allclose(biased(30.0).targets[0].wheel_bias, wanted)
    rounded = np.round(wanted, 2).tolist()
    np.testing.assert_allclose(biased(rounded).targets[0].wheel_bias, wanted, atol=0.02)
    with pytest.raises(scenarios.ScenarioError, match="the nearest that stores none is") as told:
        biased([10.0, 0.0, 0.0, 0.0])
    nearest = str(told.value).rpartition("none is [")[2].rpartition("]")[0].split(",")
    np.testing.assert_allclose(np.array(nearest, float), 10.0 * NULL[0] * NULL, atol=1e-4)
    for bias, change, words in (
        (30.0, {"vehicle.wheels.failed": ["wheel 4"]}, "at least four"),
        (30.0, {"vehicle.wheels.speed_limit_rad_s": 500.0}, None),
        ([600.0 * v for v in NULL], {"vehicle.wheels.speed_limit_rad_s": 300.0}, "speed limit"),
    ):
        if words is None:
            biased(bias, **change)
            continue
        with pytest.raises(scenarios.ScenarioError, match=words):
            biased(bias, **change)
    with pytest.raises(scenarios.ScenarioError, match="given without wheel_bias_rad_s"):
        biased(None, **{"target.wheel_bias_tolerance_rad_s": 0.2})
    earning = scenarios.load("hypso1-netpower")
    with pytest.raises(scenarios.ScenarioError, match="give wheel_speed_rad_s"):
        scenarios.replace(earning, {BIAS: 30.0})
    with pytest.raises(scenarios.ScenarioError, match="certificate"):
        jaxatt.certify(biased(30.0))
    with pytest.raises(scenarios.ScenarioError, match="sensitivities"):
        jaxatt.sensitivities(biased(30.0))


@pytest.fixture(scope="module")
def answers():
    """Of no bias, of one that the active intervals have room for, of more, and of too much."""
    return [jaxatt.solve(biased(size)) for size in (0.0, 10.0, 100.0, 3000.0)]


def test_the_flight_has_the_bias_and_the_same_motion(answers):
    still = answers[0].phases[0]
    for answer, size in zip(answers[:3], (0.0, 10.0, 100.0), strict=True):
        phase, wheels = answer.phases[0], answer.scenario.vehicle.wheels
        assert answer.reached
        end = phase.series["omega_bw"][len(phase.active)]
        np.testing.assert_allclose(bias_of(wheels, end), size * NULL, atol=1e-8)
        np.testing.assert_allclose(phase.series["q_ob"], still.series["q_ob"], atol=1e-9)
        # J_w omega_bw is the impulse of the wheel less J_w A' omega_ib.
        impulse = phase.step * phase.series["torque_wheels"].sum(axis=0)
        rate = phase.series["omega_ib"]
        turned = wheels.axes.T @ (rate[len(phase.active)] - rate[0])
        np.testing.assert_allclose(end, impulse / wheels.inertia - turned, atol=1e-8)
        assert np.abs(phase.series["torque_wheels"]).max() <= 3e-3 * (1.0 + 1e-9)
        idle = ~phase.active
        assert not phase.series["torque_wheels"][idle].any()


def test_intervals_are_added_only_where_limits_leave_no_room(answers):
    counts = [answer.phases[0].active_intervals for answer in answers]
    assert counts[:3] == [2, 2, 4]
    assert answers[2].summary()["intervals_for_bias"] == 2
    # 100 rad/s are 0.021 N m s; each free interval gives at most 1.4 s at sqrt(6 / 3) times 3 mN m.
    most = 1.4 * 3e-3 / abs(NULL[3])
    assert most < 100.0 * 2.1e-4
    failed = answers[3]
    assert not failed.reached
    assert "room for" in failed.phases[0].failure_reason
    archive = answers[1].to_dataset()
    np.testing.assert_allclose(archive.wheel_bias, 10.0 * NULL)
    assert float(archive["wheel bias_error"]) < 1e-9


def test_forbidden_intervals_stay_idle():
    windows = [{"first_interval": 1, "last_interval": 48, "forbidden": True}]
    answer = jaxatt.solve(biased(100.0, windows=windows))
    assert answer.phases[0].active_intervals == 2
    assert not answer.reached and "bias of the wheels" in answer.phases[0].failure_reason


@pytest.fixture(scope="module")
def timed():
    case = scenarios.load("mrp-k4-rk4")
    return jaxatt.solve(scenarios.replace(case, {BIAS: 60.0}), starts=4)


def test_a_turn_in_free_time_ends_with_the_bias(timed):
    phase, wheels = timed.phases[0], timed.scenario.vehicle.wheels
    assert timed.reached
    np.testing.assert_allclose(
        bias_of(wheels, phase.series["omega_bw"][-1]), 60.0 * unit_bias(wheels), atol=1e-6
    )


@pytest.mark.slow
def test_its_sensitivity_to_the_bias_is_the_difference_of_two_answers(timed):
    found = jaxatt.sensitivities(timed.scenario, [BIAS], starts=4)
    ahead, behind = (
        jaxatt.solve(scenarios.replace(timed.scenario, {BIAS: size}), starts=4).phases[0]
        for size in (60.5, 59.5)
    )
    slope = ahead.section.cost - behind.section.cost
    assert found[BIAS] == pytest.approx(slope, rel=1e-3)


@pytest.mark.slow
def test_its_time_is_that_of_ipopt(timed):
    pytest.importorskip("casadi")
    from references.ipopt_turns import Turn, least_cost

    craft, case = timed.scenario.vehicle, timed.scenario
    turn = Turn(
        np.asarray(craft.wheels.axes),
        0.55,
        np.asarray(craft.inertia),
        np.asarray(craft.inertia_without_spin),
        case.targets[0].q_ob,
        np.zeros(3),
        np.zeros(3),
        35,
        0.05 * case.targets[0].wheel_bias,
    )
    cost, time = least_cost(turn, case.objective.effort_weight, 24.0)
    assert timed.phases[0].section.cost == pytest.approx(cost, rel=1e-6)
    assert timed.phases[0].final_time == pytest.approx(time, rel=1e-5)
