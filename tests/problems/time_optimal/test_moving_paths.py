"""Starts of bodies in motion, and turns in least time with a spin or stored momentum."""

import numpy as np
import pytest
from references import random_vehicles

from jaxatt import scenarios
from jaxatt.attitude import host_turns
from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.time_optimal.moving_paths import moving_paths
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.search import search_free_time
from jaxatt.problems.time_optimal.starts import starts_of
from jaxatt.problems.time_optimal.task import ReorientationTask, TimeGoal
from jaxatt.spacecraft import create, reaction_wheels


def a_task(rng, attitude="quaternion"):
    """A turn with rates at both ends and wheels that store momentum."""
    craft = create(
        random_vehicles.inertia(rng),
        reaction_wheels(random_vehicles.wheel_axes(rng, 4), 1e-4, 2e-3),
    )
    begin = InitialState(
        random_vehicles.unit(rng, 4), 0.05 * rng.normal(size=3), 50.0 * rng.normal(size=4)
    )
    end = Target(random_vehicles.unit(rng, 4), 0.02 * rng.normal(size=3), 1e-4, 1e-6)
    return ReorientationTask(craft, begin, end, 12, TimeGoal(0.0, attitude))


@pytest.mark.parametrize("attitude", ["quaternion", "mrp"])
def test_paths_begin_and_end_as_the_manoeuvre_does_and_keep_the_momentum(attitude):
    rng = np.random.default_rng(41)
    for _ in range(5):
        task = a_task(rng, attitude)
        paths = starts_of(task, 6, 3)
        size = task.form.body.attitude_size
        x, p = paths.states, task.parameters
        np.testing.assert_allclose(x[:, 0, :-1], np.broadcast_to(p.start, x[:, 0, :-1].shape))
        np.testing.assert_allclose(x[:, -1, size : size + 3] - task.target.omega_ob, 0.0)
        if attitude == "quaternion":
            np.testing.assert_allclose(x[:, -1, :4], paths.reference, atol=1e-9)
            q, momentum = x[..., :4], x[..., -4:-1]
            inertial = host_turns.to_body(host_turns.conjugate(q), momentum)
            first = np.broadcast_to(inertial[:1, :1], inertial.shape)
            np.testing.assert_allclose(inertial, first, atol=1e-12)


def test_rates_are_those_of_the_attitudes():
    """So that the path is one motion: on a fine grid, node by node."""
    task = a_task(np.random.default_rng(42))
    task.intervals = 4000
    paths = moving_paths(task, 4, 0)
    q, omega = paths.states[..., :4], paths.states[..., 4:7]
    turned = host_turns.turn_of(host_turns.product(host_turns.conjugate(q[:, :-1]), q[:, 1:]))
    mean = 0.5 * (omega[:, 1:] + omega[:, :-1])
    np.testing.assert_allclose(turned / paths.step[:, None, None], mean, atol=2e-4)


def test_a_start_depends_on_seed_and_number_alone():
    task = a_task(np.random.default_rng(43))
    few, many = starts_of(task, 3, 5), starts_of(task, 9, 5)
    for a, b in zip(few, many, strict=True):
        np.testing.assert_array_equal(a, b[:3])
    assert np.abs(starts_of(task, 3, 6).states - few.states).max() > 1e-3


def test_a_spin_is_braked_on_the_way():
    """3 rad/s at 1 N m and 1 kg m^2: 3 s to brake, longer with half a turn about another axis."""
    changes = {"initial.rate_rad_s": [3.0, 0, 0], "horizon.intervals": 20}
    task = build_time_task(scenarios.replace(scenarios.load("minimum-time-180"), changes))
    found = search_free_time(task, 6, 0)
    assert found.reached[found.best]
    assert 3.0 < task.intervals * found.step[found.best] < 3.9


def any_turn(rng):
    """A vehicle of 1 to 500 kg, rates up to 10 deg/s at both ends, wheels half full."""

    def rate():
        return np.radians(rng.uniform(0.0, 10.0)) * random_vehicles.unit(rng, 3)

    mass = 10.0 ** rng.uniform(0.0, np.log10(500.0))
    inertia = random_vehicles.inertia(rng, mass * (0.1 * mass ** (1.0 / 3.0)) ** 2 / 6.0)
    capacity = 2.0 * np.linalg.eigvalsh(inertia).max() * np.radians(10.0)
    wheels = {
        "axes": np.eye(3).tolist(),
        "inertia_kgm2": capacity / 600.0,
        "torque_limit_Nm": capacity / rng.uniform(10.0, 60.0),
    }
    return scenarios.from_mapping(
        {
            "name": "any-turn",
            "vehicle": {"inertia_kgm2": (0.5 * (inertia + inertia.T)).tolist(), "wheels": wheels},
            "initial": {
                "attitude_deg": rng.uniform(-180.0, 180.0, 3).tolist(),
                "rate_rad_s": rate().tolist(),
                "wheel_speed_rad_s": rng.uniform(-300.0, 300.0, 3).tolist(),
            },
            "target": {
                "attitude_deg": rng.uniform(-80.0, 80.0, 3).tolist(),
                "rate_rad_s": rate().tolist(),
            },
            "horizon": {"intervals": 40, "substeps": 6},
            "objective": {"kind": "minimum-time"},
        }
    )


@pytest.mark.slow
def test_turns_of_any_vehicle_are_found():
    rng = np.random.default_rng(7)
    for _ in range(8):
        found = search_free_time(build_time_task(any_turn(rng)), 8, 0)
        assert found.reached[found.best]
        assert found.reached.sum() >= 4
