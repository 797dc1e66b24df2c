"""Reweighted least effort: fewer active intervals where the limits of the wheels bind."""

import numpy as np
from references import random_vehicles

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.polish import Method
from jaxatt.problems.hands_off.search.reweighted_effort import reweighted
from jaxatt.problems.hands_off.search.search import look


def task_of(rng):
    """A body that turns at both ends, stopped and turned by wheels that need most of the time."""
    document = {
        "name": "hurried",
        "vehicle": {
            "inertia_kgm2": random_vehicles.inertia(rng).tolist(),
            "wheels": {
                "axes": random_vehicles.wheel_axes(rng, 4).T.tolist(),
                "inertia_kgm2": 1e-4,
                "torque_limit_Nm": 2e-3,
            },
        },
        "initial": {
            "attitude_quaternion": random_vehicles.unit(rng, 4).tolist(),
            "rate_rad_s": (0.06 * random_vehicles.unit(rng, 3)).tolist(),
            "wheel_speed_rad_s": (40.0 * rng.uniform(-1.0, 1.0, 4)).tolist(),
        },
        "target": {
            "attitude_quaternion": random_vehicles.unit(rng, 4).tolist(),
            "rate_rad_s": (0.03 * random_vehicles.unit(rng, 3)).tolist(),
        },
        "horizon": {"horizon_s": 30.0, "intervals": 16, "coast_intervals": 0, "substeps": 3},
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
    return build_slew(scenarios.from_mapping(document))


def counts(task, answers):
    """Active intervals of the answers that reach, and of all others all of them."""
    active = [support_of(task, controls).any(axis=1).sum() for controls in answers.controls]
    return np.where(answers.verdict.reached, active, task.intervals)


def test_answers_keep_the_limits_and_have_fewer_active_intervals():
    rng, fewer = np.random.default_rng(71), []
    for _ in range(4):
        task = task_of(rng)
        before = look(task, 8, 0)
        after = reweighted(task, before, Method("l0", rows=8))
        fewer.append(counts(task, before) - counts(task, after))
        assert after.verdict.reached.sum() >= before.verdict.reached.sum()
    assert (np.mean(fewer, axis=1) >= 0.0).all()
    assert np.mean(fewer) > 2.0
