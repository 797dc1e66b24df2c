"""What the solver sees of a slew against quaternions, brute force and the flown wheel speeds."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references import random_vehicles

from jaxatt import scenarios
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.slew import model as slew
from jaxatt.problems.hands_off.slew.model import SlewForm
from jaxatt.problems.terminal_rows import attitude_row

HALF_TURNS = [0.0, 1e-12, 1e-6, 0.3, np.pi / 2, np.pi - 1e-9, np.pi]


def product(a, b):
    return np.concatenate(
        [[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])]
    )


def pairs():
    rng = np.random.default_rng(0)
    for _ in range(20):
        yield random_vehicles.unit(rng, 4), random_vehicles.unit(rng, 4)
    for half in [*np.array(HALF_TURNS) / 2, np.pi / 2, 2.0, 3.0]:
        reference, axis = random_vehicles.unit(rng, 4), random_vehicles.unit(rng, 3)
        turn = np.concatenate([[np.cos(half)], np.sin(half) * axis])
        yield reference, product(reference, turn)


def test_squared_attitude_row_is_eight_times_the_metric_on_its_side():
    for reference, q in pairs():
        row = np.asarray(attitude_row(jnp.asarray(reference), jnp.asarray(q)))
        np.testing.assert_allclose(row @ row, 8.0 * (1.0 - reference @ q), rtol=1e-10, atol=1e-14)
        if reference @ q >= 0:
            metric = 1.0 - abs(reference @ q)
            np.testing.assert_allclose(row @ row, 8.0 * metric, rtol=1e-10, atol=1e-14)


def test_attitude_row_points_along_the_error_and_is_four_sines_of_a_quarter():
    rng = np.random.default_rng(1)
    for angle in (1e-9, 1e-3, 1.0, 3.0, np.pi, 4.0, 6.0):
        reference, axis = random_vehicles.unit(rng, 4), random_vehicles.unit(rng, 3)
        turn = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])
        row = attitude_row(jnp.asarray(reference), jnp.asarray(product(reference, turn)))
        np.testing.assert_allclose(row, 4.0 * np.sin(angle / 4) * axis, rtol=1e-7, atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-8, 1.0, np.pi, 2 * np.pi - 1e-3, 2 * np.pi])
def test_attitude_row_has_a_finite_derivative(angle):
    rng = np.random.default_rng(2)
    reference, axis = random_vehicles.unit(rng, 4), random_vehicles.unit(rng, 3)
    q = product(reference, np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis]))
    jacobian = np.asarray(
        jax.jacobian(attitude_row, argnums=1)(jnp.asarray(reference), jnp.asarray(q))
    )
    assert np.isfinite(jacobian).all()
    if angle < 4.0:
        # Along the sphere: a small further turn d about the axis moves the row by cos(phi/4) d.
        tangent = 0.5 * product(q, np.concatenate([[0.0], axis]))
        np.testing.assert_allclose(jacobian @ tangent, np.cos(angle / 4) * axis, atol=1e-6)


@pytest.fixture(scope="module")
def scenario():
    return scenarios.replace(
        scenarios.load("hypso1-90-45-15-perturbed"),
        {
            "vehicle.wheels.speed_limit_rad_s": 100.0,
            "initial.wheel_speed_rad_s": [20.0, -30.0, 10.0, 5.0],
            "initial.rate_rad_s": [1e-3, -2e-3, 3e-3],
        },
    )


@pytest.fixture(scope="module", params=["body", "wheels"])
def task(request, scenario):
    return build_slew(scenarios.replace(scenario, {"control.axes": request.param}))


def random_u(task, seed, size=0.3):
    rng = np.random.default_rng(seed)
    return (
        size
        * rng.uniform(-1, 1, (task.intervals, task.size))
        * (rng.random((task.intervals, 1)) < 0.3)
    )


def test_torque_margins_are_the_distance_of_every_wheel_to_its_limit(task):
    u = random_u(task, 0, 2.0)
    margins = np.asarray(slew.torque_margins(jnp.asarray(u), task.arguments.plant))
    wheel = task.wheel_torque(u * task.scale)
    limit = np.asarray(task.craft.wheels.torque_limit)
    inside = (np.abs(wheel) <= limit).all(axis=1)
    np.testing.assert_array_equal((margins >= 0).all(axis=1), inside)
    assert inside.any() and not inside.all()
    count = wheel.shape[1]
    np.testing.assert_allclose(margins[:, :count], 1.0 - wheel / limit, atol=1e-12)
    np.testing.assert_allclose(margins[:, count:], 1.0 + wheel / limit, atol=1e-12)


def test_speed_margins_agree_with_the_flown_wheel_speeds(task):
    u = random_u(task, 1)
    speeds = np.asarray(
        jax.jit(slew.wheel_speeds, static_argnums=2)(
            jnp.asarray(u), task.arguments.plant, SlewForm(disturbed=True, speed_limited=True)
        )
    )
    flown = task.fly((u * task.scale)[None]).omega_bw[0, 1 : task.intervals + 1]
    assert np.ptp(flown) > 50.0
    np.testing.assert_allclose(speeds, flown, rtol=1e-6, atol=1e-5)
    margins = np.asarray(task.system.margins(jnp.asarray(u), task.arguments.plant))
    limit = 100.0
    np.testing.assert_allclose(margins.min(), 1.0 - np.abs(flown).max() / limit, atol=1e-6)


def test_rows_vanish_where_the_flight_ends(task):
    u = random_u(task, 2)
    flown = task.fly((u * task.scale)[None])
    end = task.intervals
    plant = dataclasses.replace(
        task.arguments.plant,
        reference=jnp.asarray(flown.q_ob[0, end]),
        reference_rate=jnp.asarray(flown.omega_ob[0, end]),
    )
    at_end = jax.jit(task.system.rows)(jnp.asarray(u), plant)
    # The transcription's step is coarser than the flight's: its error is what is left.
    assert float(jnp.abs(at_end).max()) < 2e-4
    assert (
        float(jnp.abs(jax.jit(task.system.rows)(jnp.asarray(u), task.arguments.plant)).max()) > 0.1
    )


def test_body_and_wheel_axes_are_the_same_problem(scenario):
    body, wheels = (
        build_slew(scenarios.replace(scenario, {"control.axes": axes}))
        for axes in ("body", "wheels")
    )
    u = random_u(body, 3)
    torque = u * body.scale
    v = wheels.from_controls(body.wheel_torque(torque))
    for name in ("rows", "margins", "stage_margins"):
        a = getattr(body.system, name)(jnp.asarray(u), body.arguments.plant)
        b = getattr(wheels.system, name)(jnp.asarray(v), wheels.arguments.plant)
        np.testing.assert_allclose(a, b, atol=1e-10)
    first, cost = body.verify(torque[None])
    second, same = wheels.verify(body.wheel_torque(torque)[None])
    for key, value in first.errors.items():
        np.testing.assert_allclose(value, second.errors[key], atol=1e-10)
    np.testing.assert_allclose(
        body.l1_effort(torque[None]), wheels.l1_effort(wheels.scale * v[None])
    )
    np.testing.assert_allclose(cost["attitude"], same["attitude"], rtol=1e-8)


def test_controls_are_within_limits_thresholded_and_keep_their_direction(task):
    rng = np.random.default_rng(4)
    u = 10.0 ** rng.uniform(-7, 1.5, (9, task.intervals, 1)) * rng.normal(
        size=(9, task.intervals, task.size)
    )
    controls = task.to_controls(u)
    limit = np.asarray(task.craft.wheels.torque_limit)
    assert (np.abs(task.wheel_torque(controls)) <= limit * (1 + 1e-12)).all()
    peak = np.abs(u * task.scale).max(axis=-1)
    silent = peak <= 1e-6  # [N m], of the source, for these wheels
    assert silent.any() and not silent.all()
    assert not controls[silent].any()
    assert (np.abs(controls[~silent]).max(axis=-1) > 0).all()
    asked = u * task.scale
    share = np.linalg.norm(controls, axis=-1) / np.linalg.norm(asked, axis=-1)
    np.testing.assert_allclose(
        controls[~silent], share[~silent][:, None] * asked[~silent], rtol=1e-9, atol=1e-20
    )
    assert (share <= 1 + 1e-12).all()
    inside = (np.abs(task.wheel_torque(asked)) <= limit).all(axis=-1) & ~silent
    assert inside.any()
    np.testing.assert_array_equal(controls[inside], asked[inside])
    np.testing.assert_allclose(task.to_controls(task.from_controls(controls)), controls, rtol=1e-12)


def test_effort_is_the_integral_of_the_body_torque(task):
    controls = task.to_controls(random_u(task, 5)[None])
    axes = np.asarray(task.craft.wheels.axes)
    body = controls if task.axes == "body" else controls @ axes.T
    np.testing.assert_allclose(task.l1_effort(controls), np.abs(body).sum() * 1.4, rtol=1e-12)


def test_printed_cost_of_doing_nothing():
    # Doing nothing costs 7.612 for (45,0,0), 29.290 for (90,0,0), 31.699 and 25.355 for the others.
    for name, printed in (
        ("hypso1-45-0-0", 7.612),
        ("hypso1-90-0-0", 29.290),
        ("hypso1-90-45-15", 31.699),
        ("hypso1-75-50-15", 25.355),
    ):
        idle = build_slew(scenarios.load(name))
        _, parts = idle.verify(np.zeros((1, idle.intervals, idle.size)))
        np.testing.assert_allclose(sum(parts.values()), printed, atol=1e-3)
