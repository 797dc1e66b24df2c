"""Targets that point one body axis: what is read of them, and where they are refused."""

from __future__ import annotations

import copy

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jaxatt
from jaxatt import scenarios
from jaxatt.environment import frames
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios import ScenarioError

Z = [0.0, 0.0, 1.0]
NADIR = {"body": Z, "toward": "nadir"}
STARS = {"body": Z, "direction_inertial": [1.0, -2.0, 0.5]}
ATTITUDES = ("attitude_deg", "attitude_quaternion", "attitude_mrp", "axis", "angle_deg")


def read(name, align, table="target", **changes):
    """A bundled scenario with another target."""
    document = copy.deepcopy(dict(scenarios.load(name).document))
    for key in (*ATTITUDES, "constrain", "rate", "rate_rad_s"):
        document[table].pop(key, None)
    document.pop("printed", None)
    document[table] |= {"align": align, **changes.pop("also", {})}
    for key, value in changes.items():
        document[key] = {**document.get(key, {}), **value}
    return scenarios.from_mapping(document, origin="s.toml")


def seen(case, time):
    """Target's attitude and rate relative to inertial axes."""
    target, here = case.targets[0], motion_of(case.orbit).at(jnp.asarray(time))
    io = Rotation.from_matrix(np.array(frames.matrix_io(here.position, here.velocity)))
    ob = Rotation.from_quat(target.q_ob, scalar_first=True)
    rate = (io * ob).apply(target.omega_ob) + io.apply(np.array(frames.omega_io(*here)))
    return io * ob, rate


def test_the_axis_points_and_rests_as_the_rate_says():
    known = np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)
    for words, wanted in (("inertial", np.zeros(3)), ("track", np.zeros(3))):
        case = read("hypso1-90-45-15", STARS, also={"rate": words})
        np.testing.assert_array_equal(case.targets[0].boresight, Z)
        turn, rate = seen(case, 70.0)
        np.testing.assert_allclose(turn.apply(Z), known, atol=1e-12)
        np.testing.assert_allclose(rate, wanted, atol=1e-14)
    carried = read("hypso1-90-45-15", STARS, also={"rate": "orbit"}).targets[0]
    np.testing.assert_array_equal(carried.omega_ob, np.zeros(3))


def test_tracking_turns_with_the_direction_and_not_about_it():
    place = {"body": Z, "toward": "site", "latitude_deg": 63.42, "longitude_deg": 10.39}
    case = read("hypso1-ground-site", place, also={"rate": "track"})
    turn, rate = seen(case, 70.0)
    assert abs(rate @ turn.apply(Z)) < 1e-9
    both = scenarios.load("hypso1-ground-site")
    whole, turning = seen(both, 70.0)
    np.testing.assert_allclose(turn.apply(Z), whole.apply(Z), atol=1e-12)
    sight = whole.apply(Z)
    np.testing.assert_allclose(np.cross(rate, sight), np.cross(turning, sight), atol=1e-9)
    assert np.linalg.norm(rate) > 0.01


def test_a_spin_about_the_axis_may_be_asked_for():
    target = read("hypso1-90-45-15", NADIR, also={"rate_rad_s": [0.0, 0.0, 0.02]}).targets[0]
    turned = target.facing(np.array([0.5, 0.5, -0.5, 0.5]))
    np.testing.assert_allclose(turned.omega_ob, [0.0, 0.0, 0.02], atol=1e-15)


def test_what_rests_may_be_pointed_at_in_free_time_whatever_the_roll():
    free = {"horizon_s": 70.0, "final_time": "free", "shortest_s": 60.0, "longest_s": 80.0}
    changes = {"horizon": free, "objective": {"time_weight_1_s": 0.1}}
    ahead = {"body": Z, "direction_orbit": [1.0, 0.0, 1.0]}
    assert read("hypso1-90-45-15", ahead, **changes).leaves_roll_free
    with pytest.raises(ScenarioError, match=r"align: moves by \d"):
        read("hypso1-90-45-15", STARS, **changes)


def test_objectives_that_decide_whole_attitudes_refuse_it():
    weights = {"terminal": "penalty", "attitude_weight_J": 1.0, "rate_weight_J_s2": 1.0}
    with pytest.raises(ScenarioError, match=r'constrain: .*"penalty".*; use "reach", or add'):
        read("hypso1-netpower", STARS, objective=weights)
    with pytest.raises(ScenarioError, match=r"constrain: .*magnetorquers.*; add constrain"):
        read("mtq-free-time", STARS)


def test_studies_of_whole_attitudes_refuse_it():
    case = read("mrp-k3-rk4", STARS)
    with pytest.raises(ScenarioError, match=r"leaves the roll free.*; add constrain"):
        jaxatt.attitude_map(case, targets=4)
