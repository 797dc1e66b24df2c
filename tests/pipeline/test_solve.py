"""`solve`: what it refuses, and what it finds for targets that nobody tuned it for."""

import jax
import numpy as np
import pytest
from references import random_vehicles, reflight

import jaxatt
from jaxatt import scenarios
from jaxatt.optimize.status import Status

STARTS = 8


def changed(changes, name="hypso1-90-45-15"):
    return scenarios.replace(scenarios.load(name), {"solver.starts": STARTS, **changes})


def turn(angle, axis):
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    return [float(np.cos(angle / 2)), *(np.sin(angle / 2) * axis)]


def solve_and_refly(scenario, **settings):
    """Solve, and insist that SciPy's flight of the answer agrees that it arrives."""
    result = jaxatt.solve(scenario, **settings)
    assert result.reached, result.phases[0].failure_reason
    reflight.assert_reached(scenario, result)
    return result


def test_single_precision_is_refused_with_the_remedy():
    with jax.enable_x64(False), pytest.raises(ValueError, match=r"jax_enable_x64 is off.*update"):
        jaxatt.solve("hypso1-90-45-15")


@pytest.mark.parametrize(
    ("guess", "words"),
    [
        (np.zeros((49, 3)), r"\(49, 3\): expected finite controls of shape \(50, 3\)"),
        (np.zeros((50, 4)), r"\(50, 4\)"),
        (np.full((50, 3), np.nan), "finite"),
        ("ones", "'ones': unknown here; choose one of pulses, pd, l1"),
    ],
)
def test_guesses_that_are_refused(guess, words):
    with pytest.raises(ValueError, match=words):
        jaxatt.solve("hypso1-90-45-15", guess=guess)


def test_the_toy_systems_have_no_pd_guess():
    with pytest.raises(ValueError, match="pd"):
        jaxatt.solve("double-integrator", guess="pd")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"objective": "l2"}, "l2"),
        ({"terminal": "soft"}, "soft"),
        ({"starts": 0}, "starts"),
        ({"seed": -1}, "seed"),
        ({"inner": "newton"}, "newton"),
    ],
)
def test_settings_that_are_refused(settings, words):
    with pytest.raises(ValueError, match=words):
        jaxatt.solve("hypso1-90-45-15", **settings)


@pytest.fixture(scope="module")
def usual():
    return solve_and_refly(changed({}))


def test_a_result_is_reproduced_by_its_seed(usual):
    again = jaxatt.solve(changed({}))
    np.testing.assert_array_equal(again.phases[0].controls, usual.phases[0].controls)
    assert usual.active_intervals == 2


def test_a_users_guess_near_the_answer_keeps_it(usual):
    result = solve_and_refly(changed({"solver.starts": 4}), guess=usual.phases[0].controls)
    assert result.active_intervals == 2
    assert result.phases[0].l1_effort <= usual.phases[0].l1_effort * (1 + 1e-6)


@pytest.mark.parametrize("guess", ["pd", "l1"])
def test_guesses_by_name(guess, usual):
    result = solve_and_refly(changed({}), guess=guess)
    assert result.active_intervals == 2
    np.testing.assert_allclose(result.phases[0].l1_effort, usual.phases[0].l1_effort, rtol=1e-3)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_attitudes(seed):
    rng = np.random.default_rng(seed)
    result = solve_and_refly(
        changed(
            {
                "initial.attitude_quaternion": random_vehicles.unit(rng, 4),
                "target.attitude_quaternion": random_vehicles.unit(rng, 4),
            }
        )
    )
    assert result.active_intervals == 2


@pytest.mark.parametrize("seed", [0, 1])
def test_half_a_turn_about_any_axis(seed):
    axis = np.random.default_rng(seed).normal(size=3)
    result = solve_and_refly(changed({"target.attitude_quaternion": turn(np.pi, axis)}))
    assert result.active_intervals <= 3


def test_a_hair_away():
    # Pulses at both ends would fall below the threshold of 1e-6 N m: few starts see the way out.
    scenario = changed(
        {
            "target.attitude_quaternion": turn(np.deg2rad(0.02), [1, 2, -1]),
            "solver.starts": 16,
        }
    )
    result = solve_and_refly(scenario)
    assert result.active_intervals == 2
    assert result.phases[0].l1_effort < 1e-4


@pytest.mark.parametrize("angle", [0.0, 0.005])
def test_nothing_to_do_is_done_with_no_torque(angle):
    # Left alone the body drifts by less than this tolerance in 70 s.
    scenario = changed(
        {
            "target.attitude_quaternion": turn(np.deg2rad(angle), [0, 0, 1]),
            "target.attitude_tolerance_deg": 0.5,
        }
    )
    result = solve_and_refly_loosely(scenario)
    assert result.active_intervals == 0
    assert not result.phases[0].controls.any()


def solve_and_refly_loosely(scenario):
    result = jaxatt.solve(scenario)
    assert result.reached, result.phases[0].failure_reason
    reflight.assert_reached(scenario, result, attitude_deg=0.5)
    return result


@pytest.mark.parametrize(
    ("target", "rate"),
    [(-170.0, 2.7), pytest.param(-110.0, 3.5, marks=[pytest.mark.slow, pytest.mark.optimised])],
)
def test_momentum_that_makes_the_long_way_cheaper_is_used(target, rate):
    # The body already turns about x, away from its target but on round to it: coasting all the
    # way and stopping there costs J_x rate; stopping and going back more.
    scenario = changed(
        {
            "target.attitude_deg": [target, 0.0, 0.0],
            "initial.rate_rad_s": [np.deg2rad(rate), 0.0, 0.0],
        }
    )
    result = solve_and_refly(scenario)
    assert result.active_intervals <= 2
    on, back = rate, rate + 2 * abs(target) / 68.6
    assert result.phases[0].l1_effort < 0.0775 * np.deg2rad(on + back) / 2


def test_a_torque_limit_too_small_is_said_to_be_in_the_way():
    result = jaxatt.solve(changed({"vehicle.wheels.torque_limit_Nm": 1e-6, "solver.starts": 4}))
    assert not result.reached
    assert result.status == "not reached"
    phase = result.phases[0]
    assert "attitude" in phase.failure_reason and "missed by" in phase.failure_reason
    assert not (phase.starts.status == Status.CONVERGED).any()
    assert not phase.starts.reached.any()
    assert phase.limit_violation <= 1e-9


def test_wheel_speed_limits_hold_in_flight():
    # Pulses at both ends turn the x wheel at J_x (60 deg / 68.6 s) 5/6 / J_w = 4.7 rad/s; any
    # pulse farther inside must turn it faster.
    limit = 4.9
    result = solve_and_refly(
        changed(
            {
                "target.attitude_deg": [60.0, 0.0, 0.0],
                "vehicle.wheels.speed_limit_rad_s": limit,
                "solver.starts": 4,
            }
        )
    )
    flown = np.abs(result.phases[0].series["omega_bw"][:51]).max()
    assert 0.9 * limit < flown <= limit * (1 + 1e-6)
    assert result.phases[0].margin_violation <= 1e-6


@pytest.mark.slow  # compiles the programme in stages with speed limits, for itself alone
@pytest.mark.optimised
def test_a_speed_limit_that_nothing_can_meet_is_said_to_be_in_the_way():
    limited = {"vehicle.wheels.speed_limit_rad_s": 1.0, "solver.starts": 8}
    result = jaxatt.solve(changed(limited))
    assert not result.reached
    assert result.phases[0].failure_reason


def test_forbidden_windows_stay_empty():
    windows = [
        {"first_interval": 0, "last_interval": 9, "forbidden": True},
        {"first_interval": 40, "last_interval": 49, "forbidden": True},
    ]
    result = solve_and_refly(changed({"windows": windows}))
    active = np.flatnonzero(result.phases[0].active)
    assert len(active) == 2
    assert active.min() >= 10 and active.max() <= 39
    assert not result.phases[0].controls[:10].any() and not result.phases[0].controls[40:].any()


@pytest.mark.slow
@pytest.mark.optimised
def test_three_wheels_are_enough():
    result = solve_and_refly(
        changed(
            {
                "vehicle.wheels.axes": np.eye(3).tolist(),
                "initial.wheel_speed_rad_s": [0.0, 0.0, 0.0],
                "target.attitude_deg": [40.0, -30.0, 100.0],
            }
        )
    )
    assert result.active_intervals == 2
    assert result.phases[0].series["omega_bw"].shape == (71, 3)


@pytest.mark.slow
@pytest.mark.optimised
def test_spinning_wheels_and_a_turning_body():
    rng = np.random.default_rng(8)
    result = solve_and_refly(
        changed(
            {
                "initial.wheel_speed_rad_s": rng.uniform(-30, 30, 4),
                "initial.rate_rad_s": 0.01 * rng.normal(size=3),
                "target.rate_rad_s": 0.001 * rng.normal(size=3),
            }
        )
    )
    assert result.active_intervals == 2


def test_wheel_axes_find_as_few_intervals(usual):
    result = solve_and_refly(changed({"control.axes": "wheels"}))
    assert result.phases[0].controls.shape == (50, 4)
    assert result.active_intervals == 2
    np.testing.assert_allclose(result.phases[0].l1_effort, usual.phases[0].l1_effort, rtol=1e-3)


def test_record_of_the_starts(usual):
    record = usual.phases[0].starts
    assert len(record.status) == STARTS
    assert record.reached.sum() >= STARTS // 2
    # Whoever arrived by flight has errors within tolerance, and the others have not.
    np.testing.assert_array_equal(record.shortfall <= 1.0, record.reached)
    phase = usual.phases[0]
    assert phase.errors["attitude"] <= phase.tolerances["attitude"]
    np.testing.assert_allclose(phase.l1_effort, np.abs(phase.controls).sum() * phase.step)
    assert set(usual.time) == {"compile", "solve", "verify"}
    assert min(usual.time.values()) >= 0.0
