"""Slews of bodies in motion: starts that brake a spin or let it coast, and what comes of them."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.pipeline.solve import solve
from jaxatt.problems.hands_off.build import build_slew

LIMIT = 7e-3


def case(rate, target_rate=(0.0, 0.0, 0.0), wheels=(0.0, 0.0, 0.0)):
    """A 12U body that turns at the start; always with as many steps, to compile once."""
    return scenarios.from_mapping(
        {
            "name": "in-motion",
            "vehicle": {
                "inertia_kgm2": [
                    [0.35, 0.004, -0.002],
                    [0.004, 0.30, 0.003],
                    [-0.002, 0.003, 0.22],
                ],
                "wheels": {
                    "axes": np.eye(3).tolist(),
                    "inertia_kgm2": 3e-5,
                    "torque_limit_Nm": LIMIT,
                },
            },
            "initial": {
                "attitude_deg": [0, 0, 0],
                "rate_rad_s": list(rate),
                "wheel_speed_rad_s": list(wheels),
            },
            "target": {"axis": [1, 2, 3], "angle_deg": 60, "rate_rad_s": list(target_rate)},
            "horizon": {"horizon_s": 150, "intervals": 60, "coast_intervals": 0, "substeps": 4},
            "objective": {"kind": "l0"},
            "orbit": {
                "semi_major_axis_km": 6898,
                "eccentricity": 0.0,
                "inclination_deg": 97.5,
                "raan_deg": 30,
                "argument_of_periapsis_deg": 0,
                "true_anomaly_deg": 0,
            },
        }
    )


def test_starts_nearly_lead_to_the_target():
    """With motion at both ends and in the wheels; without torque they would be anywhere."""
    rng = np.random.default_rng(61)
    for _ in range(4):
        rates = 0.03 * rng.normal(size=(2, 3))
        task = build_slew(case(rates[0], rates[1], 100.0 * rng.normal(size=3)))
        assert task.in_motion
        u, way = task.moving_starts(8, 0)
        np.testing.assert_array_equal(u[:3], task.moving_starts(3, 0)[0])
        assert set(way) <= {-1.0, 1.0}
        assert np.abs(u).max() <= 1.0 + 1e-12
        flown = task.fly(task.to_controls(u))
        errors = task.end_errors(flown.q_ob, flown.omega_ob)
        free = np.abs(u).max(axis=(1, 2)) < 1.0 - 1e-9
        assert free.any()
        assert np.degrees(errors["attitude"][free]).max() < 8.0
        assert errors["rate"][free].max() < 3e-3


def test_a_body_that_stays_where_it_is_has_starts_as_ever():
    assert not build_slew(case((0.0, 0.0, 0.0))).in_motion
    assert build_slew(case((0.0, 0.0, 0.0), target_rate=(0.0, 0.01, 0.0))).in_motion
    assert build_slew(case((0.0, 0.0, 0.0), wheels=(500.0, 0.0, 0.0))).in_motion


def test_five_degrees_a_second_are_braked_with_few_intervals():
    phase = solve(case((0.06, -0.04, 0.05)), starts=8).phases[0]
    assert phase.reached, phase.failure_reason
    assert np.count_nonzero(phase.active) <= 3
    assert phase.starts.reached.sum() >= 3


@pytest.mark.slow
def test_thirteen_degrees_a_second_are_braked_though_the_limit_binds():
    """0.0525 N m s about x at 0.007 N m: at least three intervals of 2.5 s for it to be gone."""
    phase = solve(case((0.15, -0.1, 0.125)), starts=8).phases[0]
    assert phase.reached, phase.failure_reason
    assert 3 <= np.count_nonzero(phase.active) <= 5


def test_a_wheel_that_turns_is_no_obstacle():
    phase = solve(case((0.0, 0.0, 0.0), wheels=(0.0, 0.0, 700.0)), starts=8).phases[0]
    assert phase.reached, phase.failure_reason
    assert np.count_nonzero(phase.active) <= 5
    assert phase.starts.reached.sum() >= 2


def test_a_target_that_turns_is_met():
    phase = solve(case((0.0, 0.0, 0.0), target_rate=(0.02, 0.03, -0.02)), starts=8).phases[0]
    assert phase.reached, phase.failure_reason
    assert np.count_nonzero(phase.active) <= 4
