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
from jaxatt.studies.time_comparison import turn_angle

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


CONE = {"name": "sun", "boresight": Z, "direction_orbit": [0.0, 0.0, 1.0], "half_angle_deg": 20.0}
AHEAD = {"body": Z, "direction_orbit": [1.0, 0.0, 0.0]}


def coned(**changes):
    """A slew from looking at the nadir to pointing an axis ahead, with one cone about it."""
    near = {"direction_orbit": [1.0, 0.1, 0.0]}
    return scenarios.from_mapping(
        {
            **dict(read("hypso1-90-45-15", AHEAD).document),
            "keep_out": [{**CONE, **near, **changes}],
        }
    )


def test_a_cone_that_no_roll_avoids_is_refused():
    said = r'"sun" contains the target \(at the roll that suits best\): the boresight is 5\.71'
    with pytest.raises(ScenarioError, match=said):
        coned()
    # An axis 30 deg off is 24.3 deg off the middle, or further, as the roll has it.
    tilted = {"boresight": [0.5, 0.0, np.sqrt(0.75)]}
    wide = 30.0 + np.rad2deg(np.arctan(0.1))
    assert coned(**tilted, half_angle_deg=wide - 0.5).leaves_roll_free
    with pytest.raises(ScenarioError, match=f"is {wide:.4g}"):
        coned(**tilted, half_angle_deg=wide + 0.5)


def test_a_spin_faster_than_the_limit_is_refused_whatever_the_roll():
    limits = {"body_rate_deg_s": 1.0}
    slow, fast = ([0.0, 0.0, np.deg2rad(rate)] for rate in (0.9, 1.2))
    assert read("hypso1-90-45-15", NADIR, also={"rate_rad_s": slow}, limits=limits)
    with pytest.raises(ScenarioError, match=r"the target \(at the roll that suits best\) turns at"):
        read("hypso1-90-45-15", NADIR, also={"rate_rad_s": fast}, limits=limits)


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("hypso1-netpower", {"target": {"wheel_bias_rad_s": 1.0}}, "give wheel_speed_rad_s"),
        ("hypso1-netpower", {"limits": {"body_rate_deg_s": 1.0}}, "body_rate_deg_s .* unknown key"),
        ("hypso1-netpower", {"keep_out": [CONE]}, "keep_out: has no meaning for kind = net-power"),
        ("mrp-k3-rk4", {"waypoint": {"node": 3}}, "such turns pass no waypoint, drop it"),
        ("mrp-k3-rk4", {"legs": [{}]}, "such turns have one target, drop it"),
        ("eseo-1", {"waypoint": {"node": 3, "attitude_deg": [0.0] * 3}}, "use .*legs"),
        ("eseo-1", {"objective": {"kind": "l0", "design": 2}}, "use design = 1"),
        ("hypso1-90-45-15", {"waypoint": {"node": 3, "align": STARS}}, "add constrain"),
        ("hypso1-90-45-15", {"initial": {"align": STARS}}, "only a target may leave the roll"),
    ],
)
def test_what_a_family_lacks_is_refused_beside_a_free_roll_too(name, changes, said):
    document = copy.deepcopy(dict(read(name, STARS).document))
    for key, value in changes.items():
        document[key] = {**document.get(key, {}), **value} if key == "target" else value
    with pytest.raises(ScenarioError, match=said):
        scenarios.from_mapping(document, origin="s.toml")


def test_speeds_that_the_roll_decides_are_refused():
    still, moving = [0.0] * 3, [50.0, 0.0, 0.0]
    wanted = {"wheel_speed_rad_s": still}
    assert read("hypso1-netpower", STARS, also=wanted).leaves_roll_free
    with pytest.raises(ScenarioError, match=r"wheel_speed_rad_s .* roll that is free.*; drop it"):
        read("hypso1-netpower", STARS, also=wanted, initial={"wheel_speed_rad_s": moving})


def test_the_angle_of_a_comparison_is_that_of_the_axis():
    found = read("mrp-k3-rk4", STARS)
    q = Rotation.from_quat(found.initial.q_ob, scalar_first=True)
    along = np.array([1.0, -2.0, 0.5]) / np.sqrt(5.25)
    assert turn_angle(found) == pytest.approx(np.arccos(q.apply(Z) @ along))


def test_studies_of_whole_attitudes_refuse_it():
    case = read("mrp-k3-rk4", STARS)
    with pytest.raises(ScenarioError, match=r"leaves the roll free.*; add constrain"):
        jaxatt.attitude_map(case, targets=4)
