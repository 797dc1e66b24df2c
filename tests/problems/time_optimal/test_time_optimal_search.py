"""Starts of reorientations and their search: feasible paths, limits on the way, edge cases."""

import dataclasses
import functools

import jax
import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.optimize.status import Status
from jaxatt.pipeline.solve import solve
from jaxatt.problems.time_optimal import arcs
from jaxatt.problems.time_optimal.batch import solve_paths
from jaxatt.problems.time_optimal.phase import build_time_task
from jaxatt.problems.time_optimal.random_paths import random_paths
from jaxatt.problems.time_optimal.search import search_free_time


def case(name="mrp-k4-rk4", **changes):
    """A short turn; always with a shortest and a longest time, so that all of them compile once."""
    usual = {"intervals": 12, "shortest_s": 1e-3, "longest_s": 90.0}
    given = {f"horizon.{key}": value for key, value in usual.items()} | {"solver.starts": 6}
    return scenarios.replace(scenarios.load(name), given | changes)


def kinematics(sigma):
    s = sigma
    skew = np.array([[0, -s[2], s[1]], [s[2], 0, -s[0]], [-s[1], s[0], 0]])
    return 0.25 * ((1 - s @ s) * np.eye(3) + 2 * skew + 2 * np.outer(s, s))


@pytest.mark.parametrize("name", ["mrp-k3", "mrp-k4", "mrp-k5"])
def test_paths_are_feasible_solutions_of_the_printed_problem(name):
    """Forward Euler as printed, (15) and (18), from rest: at the target, at rest, within limits."""
    task = build_time_task(scenarios.load(name))
    paths = random_paths(task, 6, 3)
    torque = task.torques(paths.u)
    axes = np.asarray(task.craft.wheels.axes)
    inverse = np.linalg.inv(np.asarray(task.craft.inertia_without_spin))
    for u, h in zip(torque, paths.step, strict=True):
        sigma, omega = np.zeros(3), np.zeros(3)
        for row in u:
            sigma, omega = sigma + h * kinematics(sigma) @ omega, omega - h * inverse @ axes @ row
        np.testing.assert_allclose(sigma, task.turn(1.0), atol=1e-9)
        np.testing.assert_allclose(omega, 0.0, atol=1e-12)
        assert np.abs(u).max() == pytest.approx(0.55, rel=1e-9)


def test_start_depends_on_seed_and_number_alone():
    task = build_time_task(case())
    few, many = random_paths(task, 3, 5), random_paths(task, 9, 5)
    for a, b in zip(few, many, strict=True):
        np.testing.assert_array_equal(a, b[:3])
    assert np.abs(random_paths(task, 3, 6).u - few.u).max() > 1e-3


def test_half_a_turn_is_tried_both_ways():
    paths = random_paths(build_time_task(scenarios.load("minimum-time-180")), 40, 0)
    ways = np.sign(np.sum(paths.reference * paths.reference[0], axis=1))
    assert 8 < (ways > 0).sum() < 32


@functools.cache
def found(starts=6):
    return search_free_time(build_time_task(case()), starts, 0)


def test_all_starts_meet_in_one_minimum_that_flies():
    result = found()
    assert (result.status == Status.CONVERGED).all()
    assert result.minima == 1 and result.share == 1.0
    assert result.reached.all()
    assert np.degrees(result.verdict.errors["attitude"]).max() < 1e-2


def test_a_start_depends_on_itself_alone():
    """Other neighbours, another place, one of them not a number: the same to the last bit."""
    task = build_time_task(case())
    paths = random_paths(task, 6, 0)
    alone = solve_paths(task, paths)
    order = np.array([4, 2, 0, 5, 1, 3, 4])
    moved = type(paths)(*(values[order].copy() for values in paths))
    moved.u[6] = np.nan
    among = solve_paths(task, moved)
    for a, b in zip(jax.tree.leaves(alone), jax.tree.leaves(among), strict=True):
        np.testing.assert_array_equal(a[order[:6]], b[:6])
    assert among.status[6] == Status.NOT_FINITE


def test_new_values_do_not_compile_again(compilations):
    found()
    compilations.clear()
    task = build_time_task(case(**{"target.attitude_mrp": [0.2, -0.1, 0.15]}))
    other = search_free_time(task, 6, 0)
    assert other.reached[other.best]
    assert not compilations


def test_a_longest_time_that_does_not_bind_changes_nothing():
    """However far it is, and where starts lie on it."""
    usual = found()
    best = 12 * usual.step[usual.best]
    rng = np.random.default_rng(21)
    for factor in (1.001, *10.0 ** rng.uniform(0.02, 7.0, 4)):
        task = build_time_task(case(**{"horizon.longest_s": float(factor * best)}))
        other = search_free_time(task, 6, 0)
        # So near that hardly any room is left, some starts end feasible and no better.
        assert factor < 1.01 or (other.status == Status.CONVERGED).all(), factor
        assert other.reached[other.best]
        assert 12 * other.step[other.best] == pytest.approx(best, rel=1e-7), factor


def test_a_shortest_time_matters_only_where_it_binds():
    usual = found()
    best = 12 * usual.step[usual.best]
    for factor in (1e-7, 0.999, 1.2):
        goal = {"horizon.shortest_s": float(factor * best)}
        other = search_free_time(build_time_task(case(**goal)), 6, 0)
        assert (other.status == Status.CONVERGED).all(), factor
        np.testing.assert_allclose(12 * other.step, max(1.0, factor) * best, rtol=1e-6)


LIMITS = {
    "keep_out": [
        {
            "name": "camera",
            "boresight": [1.0, 0.0, 0.0],
            "half_angle_deg": 12.0,
            "direction_inertial": [0.8, 0.6, -0.05],
        }
    ],
    "limits.body_rate_deg_s": 4.0,
    "vehicle.wheels.speed_limit_rad_s": 60.0,
}


@functools.cache
def limited():
    """The same turn with a cone, a rate limit and speed limits of the wheels in its way."""
    free, tight = case(), case(**LIMITS)
    vehicle = free.vehicle
    wheels = dataclasses.replace(vehicle.wheels, speed_limit=np.full(vehicle.wheels.count, 95.0))
    tight = dataclasses.replace(tight, vehicle=dataclasses.replace(vehicle, wheels=wheels))
    return tight, solve(tight).phases[0]


def test_limits_on_the_way_hold_between_nodes_too():
    phase, unlimited = limited()[1], found()
    assert phase.reached, phase.failure_reason
    assert phase.final_time > unlimited.step[unlimited.best] * 12 + 1e-3
    speeds = np.abs(phase.series["omega_bw"])
    assert speeds.max() <= 95.0 * (1.0 + 1e-6)
    assert all(extreme.satisfied for extreme in phase.pointing.extremes)


def test_limits_would_be_broken_without_them():
    """So the test above tests something: what binds there is broken by the free turn."""
    task, unlimited = build_time_task(limited()[0]), found()
    index = unlimited.best
    torque, step = unlimited.controls[index][None], unlimited.step[index][None]
    flown = task.fly(torque, step, between=20)
    assert task.judge(flown, torque, step).margin_violation[0] > 1e-3


def test_at_the_target_there_is_nothing_to_do():
    here = {"target.attitude_mrp": [0.0, 0.0, 0.0], "horizon.shortest_s": None}
    task = build_time_task(case(**here))
    result = search_free_time(task, 6, 0)
    assert result.step[result.best] == 0.0 and not result.controls.any()
    assert result.reached.all()


def test_a_time_limit_that_is_too_short_is_an_obstacle_in_words():
    phase = solve(case(**{"horizon.longest_s": 20.0})).phases[0]
    assert not phase.reached
    assert "missed" in phase.failure_reason or "solver" in phase.failure_reason


def test_arcs_are_read_from_torques_with_a_switch_inside_an_interval():
    u = np.array([[1.0, -1.0], [1.0, -1.0], [0.5, -1.0], [-1.0, 1.0], [-1.0, 1.0]])
    lengths, levels = arcs._read(u, 2.0, np.full(2, -1.0), np.ones(2))
    np.testing.assert_allclose(lengths, [5.5, 0.5, 4.0])
    np.testing.assert_allclose(levels, [[1, -1], [-1, -1], [-1, 1]])
    assert (
        arcs._read(np.array([[1.0], [0.2], [0.1], [0.3], [-1.0]]), 1.0, *np.array([[-1], [1]]))
        is None
    )


def test_euler_form_is_what_the_scenario_says():
    body = build_time_task(scenarios.load("mrp-k4")).form.body
    assert (body.attitude, body.integration, body.momentum) == ("mrp", "euler", "zero")
