"""Cones and rate limits as files give them, and every refusal with the place and the mend."""

import copy
import re

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxatt import scenarios
from jaxatt.environment.sun import sun_direction
from jaxatt.problems.along_orbit import to_inertial
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios import ScenarioError

NAME = "hypso1-90-45-15-keep-out"
CONE = {"name": "camera", "boresight": [0.0, 0.0, 2.0], "half_angle_deg": 20.0}
PLACE = {"latitude_deg": 63.42, "longitude_deg": 10.39}
UP, DOWN = [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]


def changed(keep_out=None, keep_in=None, name=NAME, **changes):
    return scenarios.replace(
        scenarios.load(name), {"keep_out": keep_out, "keep_in": keep_in, **changes}
    )


def refusal(**given):
    with pytest.raises(ScenarioError) as told:
        changed(**given)
    return str(told.value)


def test_cones_of_a_file():
    case = changed(
        keep_out=[{**CONE, "direction_orbit": UP}],
        keep_in=[
            {
                "name": "panel",
                "boresight": [3.0, 0.0, 4.0],
                "half_angle_deg": 170.0,
                "toward": "nadir",
            }
        ],
        **{"limits.body_rate_deg_s": [3.0, 4.0, 5.0]},
    )
    out, inner = case.pointing.cones
    assert (out.kind, inner.kind) == ("keep-out", "keep-in")
    np.testing.assert_allclose(out.boresight, [0, 0, 1])
    np.testing.assert_allclose(inner.boresight, [0.6, 0, 0.8])
    seen = case.pointing.directions(np.array([0.0, 1000.0]))
    np.testing.assert_allclose(seen[:, 0], -seen[:, 1], atol=1e-12)
    here = motion_of(case.orbit).at(jnp.asarray([0.0, 1000.0])).position
    np.testing.assert_allclose(seen[:, 1] * np.linalg.norm(here, axis=1)[:, None], -here)
    np.testing.assert_allclose(np.rad2deg([out.half_angle, inner.half_angle]), [20, 170])
    np.testing.assert_allclose(case.pointing.rate_limit, np.deg2rad([3, 4, 5]))
    one = changed(**{"limits.body_rate_deg_s": 2.0})
    np.testing.assert_allclose(one.pointing.rate_limit, np.deg2rad([2, 2, 2]))
    assert not scenarios.load("hypso1-90-45-15").pointing


def test_directions_follow_the_orbit_and_the_sun():
    cones = [
        {**CONE, "direction_orbit": [1.0, 2.0, 3.0], "half_angle_deg": 1.0},
        {**CONE, "name": "sun", "toward": "sun", "half_angle_deg": 1.0},
        {**CONE, "name": "star", "direction_inertial": [1.0, 1.0, 0.0], "half_angle_deg": 1.0},
    ]
    task = build_slew(changed(keep_out=cones))
    seen, q = task.path_monitor.directions, np.asarray(task.path_monitor.fine.nodes.orbit_attitude)
    assert seen.shape == (70 * 20 + 1, 3, 3)
    turned = Rotation.from_quat(q[:, [1, 2, 3, 0]]).apply(np.array([1.0, 2.0, 3.0]) / np.sqrt(14))
    np.testing.assert_allclose(seen[:, 0], turned, atol=1e-12)
    # The equinox of 2026 is on 20 March: at the solstice the sun stands 23.44 deg north.
    np.testing.assert_allclose(np.rad2deg(np.arcsin(seen[0, 1, 2])), 23.44, atol=0.02)
    days = scenarios.load(NAME).orbit.days
    np.testing.assert_allclose(seen[0, 1], sun_direction(np.asarray(days)), atol=1e-12)
    np.testing.assert_allclose(
        seen[:, 2], np.array([[1.0, 1.0, 0.0]]) / np.sqrt(2) + 0 * seen[:, 2]
    )


@pytest.mark.parametrize(
    ("cone", "words"),
    [
        ({"half_angle_deg": 0.0}, ["no. 1 half_angle_deg = 0.0", "greater than 0"]),
        ({"half_angle_deg": 180.0}, ["half_angle_deg = 180.0", "less than 180"]),
        ({"half_angle_deg": "wide"}, ["half_angle_deg", "not a number"]),
        ({"boresight": [0.0, 0.0, 0.0]}, ["boresight", "is zero", "[0.0, 0.0, 1.0]"]),
        ({"boresight": [0.0, 1.0]}, ["boresight", "has 2 entries"]),
        ({"direction_orbit": [0, 0, 0]}, ["direction_orbit", "is zero"]),
        ({"toward": "sun"}, ["given beside toward", "keep one of the two"]),
        ({"direction_orbit": None}, ["no direction is given", "exactly one of"]),
        (
            {"direction_orbit": None, "toward": "moon"},
            ["moon", "allowed: nadir, velocity, sun, field, site, satellite"],
        ),
        ({"half_angle": 3.0}, ["half_angle", "did you mean 'half_angle_deg'?"]),
        ({"name": ""}, ["name", "must be a text"]),
    ],
)
def test_cones_that_are_refused(cone, words):
    given = {**CONE, "direction_orbit": UP, **cone}
    given = {key: value for key, value in given.items() if value is not None}
    message = refusal(keep_out=[given])
    assert "[[keep_out]] no. 1" in message
    for word in words:
        assert word in message


def test_the_sun_needs_a_date_and_an_orbit():
    sun = [{**CONE, "toward": "sun"}]
    assert "epoch" in refusal(keep_out=sun, **{"orbit.epoch": None})
    assert "needs an orbit" in refusal(keep_out=sun, name="eseo-1")
    assert "is no moment" in refusal(keep_out=sun, **{"orbit.epoch": "midsummer"})
    assert "1950-01-01 to 2050-01-01" in refusal(keep_out=sun, **{"orbit.epoch": "2051-01-01"})


@pytest.mark.parametrize("place", ["start", "target"])
def test_a_keep_out_cone_around_an_end_is_named(place):
    # Body z looks at the nadir at the start; at the target, (90, 45, 15) deg, somewhere else.
    turned = Rotation.from_euler("ZYX", [15, 45, 90], degrees=True).apply([0.0, 0.0, 1.0])
    direction = DOWN if place == "start" else turned.tolist()
    message = refusal(keep_out=[{**CONE, "direction_orbit": direction}])
    assert f'[[keep_out]] "camera" contains the {place}' in message
    assert "half_angle_deg = 20" in message and "narrow the cone" in message
    assert "deg from the direction" in message


MOVING = [
    {"toward": "nadir"},
    {"toward": "velocity"},
    {"toward": "sun"},
    {"toward": "field"},
    {"toward": "site", **PLACE},
    {"toward": "satellite", "satellite": {"tle_file": "other.tle"}},
    {"right_ascension_deg": 40.0, "declination_deg": -20.0},
    {"direction_inertial": [1.0, 2.0, 3.0]},
    {"direction_orbit": [1.0, 2.0, -3.0]},
]


def test_cones_and_attitudes_know_the_same_directions(tmp_path):
    case = scenarios.load("hypso1-ground-site")
    first, second = case.document["orbit"]["tle"]
    ahead = element_line(second, 43, f"{float(second[43:51]) + 2.0:8.4f}")
    (tmp_path / "other.tle").write_text(f"{first}\n{ahead}\n")
    body, across = [0.0, 0.0, 1.0], {"body": [1.0, 0.0, 0.0], "direction_inertial": [0.1, 3.0, 1.0]}
    for given in MOVING:
        document = copy.deepcopy(dict(case.document))
        document["target"].update(align={"body": body, **given}, constrain=across, rate="inertial")
        document["keep_out"] = [
            {"name": "needle", "boresight": [1.0, 0.3, 0.2], "half_angle_deg": 0.01, **given}
        ]
        found = scenarios.from_mapping(document, folder=tmp_path)
        end = np.array([found.horizon.duration])
        q_ib, _ = to_inertial(motion_of(found.orbit), end, found.targets[0].q_ob[None], np.zeros(3))
        aimed = Rotation.from_quat(q_ib[0], scalar_first=True).apply(body)
        np.testing.assert_allclose(found.pointing.directions(end)[0, 0], aimed, atol=1e-9)


def test_a_satellite_that_the_earth_hides_or_that_is_this_one_is_refused(tmp_path):
    case = scenarios.load("hypso1-ground-site")
    first, second = case.document["orbit"]["tle"]
    document = copy.deepcopy(dict(case.document))
    document["target"]["align"] = {"body": [0.0, 0.0, 1.0], "toward": "satellite"}
    for ahead, said in ((0.0, "m away at .*, which gives no direction"), (120.0, "out of sight")):
        moved = element_line(second, 43, f"{(float(second[43:51]) + ahead) % 360.0:8.4f}")
        document["target"]["align"]["satellite"] = {"tle": [first, moved]}
        with pytest.raises(ScenarioError, match=f"the other satellite is .*{said}") as refused:
            scenarios.from_mapping(document)
    # On a circle of 6798 km: half of the 120 deg between them below the horizontal.
    stated = float(re.search(r"stands ([\d.]+) deg below", str(refused.value)).group(1))
    assert stated == pytest.approx(np.rad2deg(np.arcsin(6378.0 / 6798.0)) - 30.0, abs=0.3)


def element_line(line, column, text):
    """A line of two-line elements with other characters from a column on, and its checksum."""
    line = line[:column] + text + line[column + len(text) : 68]
    digits = sum(int(c) if c.isdigit() else c == "-" for c in line)
    return line + str(digits % 10)


def test_a_family_without_an_orbit_refuses_directions_that_need_one():
    for given in ({"toward": "sun"}, {"toward": "site", **PLACE}, {"direction_orbit": UP}):
        message = refusal(name="mrp-k4-rk4", keep_out=[{**CONE, **given}])
        assert "needs an orbit; kind = time-effort is solved without an orbit" in message
        assert "right_ascension_deg" in message
    star = {"right_ascension_deg": 0.0, "declination_deg": -90.0, "half_angle_deg": 1.0}
    toward = changed(name="mrp-k4-rk4", keep_out=[{**CONE, **star}]).pointing
    np.testing.assert_allclose(toward.directions(np.zeros(1))[0, 0], UP, atol=1e-12)


def test_a_keep_in_cone_toward_a_place_out_of_sight_is_refused():
    away = {**CONE, "toward": "site", **PLACE, "latitude_deg": -33.0}
    message = refusal(name="hypso1-ground-site", keep_in=[away])
    assert "the place -33, 10.39 deg is out of sight" in message and "[[keep_in]]" in message
    changed(name="hypso1-ground-site", keep_out=[away])


def test_a_keep_in_cone_that_leaves_out_an_end_is_named():
    message = refusal(keep_in=[{**CONE, "direction_orbit": DOWN}])
    assert '[[keep_in]] "camera" excludes the target' in message and "widen the cone" in message
    angle = np.rad2deg(
        np.arccos(Rotation.from_euler("ZYX", [15, 45, 90], degrees=True).as_matrix()[2, 2])
    )
    assert f"{angle:.4g}" in message


def test_a_boresight_on_the_cone_itself_is_allowed():
    edge = {**CONE, "half_angle_deg": 90.0}  # exactly where body z looks at the start
    changed(keep_out=[{**edge, "direction_orbit": [0.0, 1.0, 0.0]}])
    message = refusal(keep_out=[{**edge, "direction_orbit": [0.0, -1.0, 0.0]}])
    assert "contains the target: the boresight is 15 deg" in message


def test_cones_that_exclude_each_other():
    both = [
        {**CONE, "direction_orbit": DOWN},
        {**CONE, "name": "antenna", "direction_orbit": UP, "half_angle_deg": 60.0},
    ]
    message = refusal(keep_in=both)
    assert '"camera" and "antenna" exclude each other 0 s after' in message
    assert "180 deg" in message


def test_names_and_tables():
    assert "another cone has it" in refusal(
        keep_out=[{**CONE, "direction_orbit": UP}, {**CONE, "direction_orbit": UP}]
    )
    with pytest.raises(ScenarioError, match="double brackets"):
        changed(keep_out={**CONE, "direction_orbit": UP})
    with pytest.raises(ScenarioError, match="keep_out: has no meaning"):
        scenarios.replace(scenarios.load("double-integrator"), {"keep_out": [CONE]})


@pytest.mark.parametrize(
    ("rate", "words"),
    [
        (0.0, "must be greater than 0"),
        ([1.0, -1.0, 1.0], "greater than 0"),
        ([1.0, 1.0], "has 2 entries"),
        (0.05, "the start turns at"),
    ],
)
def test_rates_that_are_refused(rate, words):
    # At rest in the orbit frame the body turns at 0.064 deg/s with it.
    message = refusal(**{"limits.body_rate_deg_s": rate})
    assert "[limits] body_rate_deg_s" in message and words in message
