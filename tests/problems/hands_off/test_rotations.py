"""The same slew in body axes turned at random takes as many intervals: nothing depends on axes."""

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.attitude.host_turns import product, to_body
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.search.candidates import support_of
from jaxatt.problems.hands_off.search.search import search

INERTIA = np.array([[0.0775, 0.0002, -0.0002], [0.0002, 0.1067, 0.0005], [-0.0002, 0.0005, 0.0389]])
AXES = np.vstack([np.eye(3), np.full(3, 3.0**-0.5)])
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


def attitude(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def task_of(ends, limit, turn, rate=(0.0, 0.0, 0.0), speeds=(0.0, 0.0, 0.0, 0.0)):
    """A slew between two attitudes of a vehicle whose body axes are turned by a quaternion."""
    matrix = np.stack([to_body(turn, axis) for axis in np.eye(3)], axis=1)
    begin, end = (product(q, turn).tolist() for q in ends)
    return build_slew(
        scenarios.from_mapping(
            {
                "name": "turned",
                "vehicle": {
                    "inertia_kgm2": (matrix @ INERTIA @ matrix.T).tolist(),
                    "wheels": {
                        "axes": (AXES @ matrix.T).tolist(),
                        "inertia_kgm2": 2.1e-4,
                        "torque_limit_Nm": limit,
                    },
                },
                "orbit": {
                    "semi_major_axis_km": 6852.2,
                    "eccentricity": 0.002,
                    "inclination_deg": 97.0,
                    "raan_deg": 280.0,
                    "argument_of_periapsis_deg": 0.0,
                    "true_anomaly_deg": 0.0,
                },
                "initial": {
                    "attitude_quaternion": begin,
                    "rate_rad_s": (matrix @ rate).tolist(),
                    "wheel_speed_rad_s": list(speeds),
                },
                "target": {
                    "attitude_quaternion": end,
                    "attitude_tolerance_deg": 0.01,
                    "rate_tolerance_rad_s": 1e-5,
                },
                "horizon": {"horizon_s": 70.0, "intervals": 20},
                "objective": {"kind": "l0"},
            }
        )
    ), matrix


def active(task):
    best = search(task, 8, 0).best
    assert best.verdict.reached[0]
    return int(support_of(task, best.controls[0]).sum())


def test_the_count_is_that_of_the_vehicle_whatever_its_axes():
    """A slew in two frames, whose torque limits bind."""
    rng = np.random.default_rng(2)
    ends = attitude(rng), attitude(rng)
    plain, turned = (
        active(task_of(ends, 10.0**-3.65, turn)[0]) for turn in (UNTURNED, attitude(rng))
    )
    assert plain == turned > 3, "no limit binds"


@pytest.mark.slow
def test_the_count_is_that_of_the_vehicle_in_many_frames():
    """Two slews in three frames each, with torque limits that bind more and less."""
    rng = np.random.default_rng(1630)
    for _ in range(2):
        ends, limit = (attitude(rng), attitude(rng)), 10.0 ** rng.uniform(-3.8, -3.25)
        turns = (UNTURNED, *(attitude(rng) for _ in range(2)))
        assert len({active(task_of(ends, limit, turn)[0]) for turn in turns}) == 1


def test_starts_in_motion_turn_with_the_axes():
    rng = np.random.default_rng(1631)
    for _ in range(3):
        ends = attitude(rng), attitude(rng)
        rate, speeds = 0.02 * rng.normal(size=3), 50.0 * rng.normal(size=4)
        plain, _ = task_of(ends, 2e-3, UNTURNED, rate, speeds)
        turned, matrix = task_of(ends, 2e-3, attitude(rng), rate, speeds)
        expected, way = plain.moving_starts(6, 0)
        found, same_way = turned.moving_starts(6, 0)
        np.testing.assert_allclose(found, expected @ matrix.T, atol=1e-9)
        np.testing.assert_array_equal(same_way, way)
