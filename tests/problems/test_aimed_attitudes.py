"""Attitudes that scenarios tell by directions of body axes, and rates told in words."""

from __future__ import annotations

import copy

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxatt import scenarios
from jaxatt.environment import frames
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios import ScenarioError

X, Z = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
NADIR, FORWARD = {"body": Z, "toward": "nadir"}, {"body": X, "toward": "velocity"}
SITE = {"body": Z, "toward": "site", "latitude_deg": 63.42, "longitude_deg": 10.39}
GONE = object()


def document(name="hypso1-ground-site", **tables):
    found = copy.deepcopy(dict(scenarios.load(name).document))
    for table, changes in tables.items():
        inner = found.setdefault(table, {})
        for key, value in changes.items():
            if value is GONE:
                inner.pop(key)
            else:
                inner[key] = value
    return found


def read(name="hypso1-ground-site", **tables):
    return scenarios.from_mapping(document(name, **tables), origin="s.toml")


def inertial(case, q_ob, omega_ob, time):
    """Attitude and rate relative to inertial axes of a state relative to the orbit frame."""
    here = motion_of(case.orbit).at(jnp.asarray(float(time)))
    io = Rotation.from_matrix(np.array(frames.matrix_io(here.position, here.velocity)))
    ob = Rotation.from_quat(q_ob, scalar_first=True)
    return io * ob, omega_ob + ob.inv().apply(np.array(frames.omega_io(*here))), here


@pytest.fixture(scope="module")
def case():
    return read()


def test_nadir_and_velocity_are_the_axes_of_a_circular_orbit(case):
    # The orbit frame's x axis lies along the velocity but for the path's slope.
    turn = Rotation.from_quat(case.initial.q_ob, scalar_first=True)
    assert np.rad2deg(turn.magnitude()) < 1e-9
    np.testing.assert_array_equal(case.initial.omega_ob, np.zeros(3))


def test_rest_among_the_stars_is_no_rotation_there():
    stars = {"body": Z, "right_ascension_deg": 110.0, "declination_deg": -20.0}
    for name, time in (("initial", 0.0), ("target", 70.0)):
        case = read(**{name: {"align": stars, "rate": "inertial"}})
        state = case.initial if name == "initial" else case.targets[0]
        turn, rate, here = inertial(case, state.q_ob, state.omega_ob, time)
        np.testing.assert_allclose(rate, 0.0, atol=1e-15)
        ra, dec = np.deg2rad([110.0, -20.0])
        known = [np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)]
        np.testing.assert_allclose(turn.apply(Z), known, atol=1e-12)
        across = np.cross(known, np.array(here.velocity))
        assert turn.apply(X) @ across == pytest.approx(0.0, abs=1e-8)
        assert turn.apply(X) @ np.array(here.velocity) > 0.0


def test_a_tracked_place_is_followed(case):
    target = case.targets[0]
    turn, rate, here = inertial(case, target.q_ob, target.omega_ob, 70.0)
    later = read(horizon={"horizon_s": 70.2}).targets[0]
    after, _, _ = inertial(case, later.q_ob, later.omega_ob, 70.2)
    turned = (turn.inv() * after).as_rotvec() / 0.2
    np.testing.assert_allclose(turned, rate, atol=1e-5)
    assert np.linalg.norm(rate) > 0.01
    # The boresight meets the Earth where the place is, 500 to 600 km away.
    sight = turn.apply(Z)
    distances = np.linspace(4e5, 8e5, 4001)
    radii = np.linalg.norm(np.array(here.position) + distances[:, None] * sight, axis=1)
    assert np.abs(radii - 6.3612e6).min() < 1e3


def test_frames_of_net_power_and_of_turns_in_free_time():
    stars = {"body": X, "direction_inertial": [1.0, 2.0, 3.0]}
    second = {"body": Z, "direction_inertial": [0.0, 1.0, 0.0]}
    aims = {"align": stars, "constrain": second}
    turn = read("mrp-k4-rk4", target={"attitude_mrp": GONE, **aims})
    net = document("hypso1-netpower")
    for key in [key for key in net["target"] if key.startswith("attitude_") and "tol" not in key]:
        net["target"].pop(key)
    net["target"].update(aims, frame="inertial")
    both = [turn.targets[0].q_ob, scenarios.from_mapping(net).targets[0].q_ob]
    for q in both:
        pointed = Rotation.from_quat(q, scalar_first=True).apply(X)
        np.testing.assert_allclose(pointed, np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0), atol=1e-12)
    with pytest.raises(ScenarioError, match="needs an orbit"):
        read("mrp-k4-rk4", target={"attitude_mrp": GONE, "align": NADIR, "constrain": second})


def test_a_target_that_moves_with_a_free_final_time_is_refused():
    free = {"horizon_s": 70.0, "final_time": "free", "shortest_s": 60.0, "longest_s": 80.0}
    with pytest.raises(ScenarioError, match=r"align: moves by \d+\.\d deg between"):
        read(horizon=free, objective={"time_weight_1_s": 0.1})
    rests = {"align": NADIR, "constrain": {"body": X, "direction_orbit": [1.0, 1.0, 0.0]}}
    found = read(
        horizon=free, objective={"time_weight_1_s": 0.1}, target={**rests, "rate": "orbit"}
    )
    angle = Rotation.from_quat(found.targets[0].q_ob, scalar_first=True).as_rotvec(degrees=True)
    np.testing.assert_allclose(angle, [0.0, 0.0, 45.0], atol=1e-9)


def test_another_form_takes_the_place_of_the_aims(case):
    other = scenarios.replace(
        case, {"target.attitude_deg": [10.0, 0.0, 0.0], "target.rate": "orbit"}
    )
    assert "align" not in other.document["target"] and "constrain" not in other.document["target"]
    np.testing.assert_allclose(other.targets[0].q_ob[1], np.sin(np.deg2rad(5.0)))


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"initial": {"constrain": GONE}},
         ["constrain: missing beside align", "only a target may", "toward"]),
        ({"target": {"constrain": GONE, "rate": GONE, "rate_rad_s": [0.0, 0.01, 0.0]}},
         ["rate_rad_s", "depends on the roll that is free", "add constrain"]),
        ({"waypoint": {"align": NADIR, "time_s": 35.0}}, ["[waypoint] constrain: missing"]),
        ({"target": {"align": GONE}}, ["align: missing beside constrain"]),
        ({"target": {"attitude_deg": [0, 0, 0]}}, ["align: given beside attitude_deg"]),
        ({"target": {"align": {**NADIR, "toward": "nadr"}}}, ["did you mean 'nadir'"]),
        ({"target": {"align": {"body": Z}}}, ["no direction is given", "exactly one of"]),
        ({"target": {"align": {**NADIR, "direction_inertial": X}}}, ["given beside toward"]),
        ({"target": {"align": {**NADIR, "latitude_deg": 3.0}}}, ["no meaning with nadir"]),
        ({"target": {"align": {**NADIR, "body": [0, 0, 0]}}}, ["is no direction"]),
        ({"target": {"align": {**SITE, "latitude_deg": 98.0}}}, ["latitude_deg = 98"]),
        ({"target": {"align": {**SITE, "latitude_deg": -33.0}}},
         ["the place -33, 10.39 deg is out of sight", "horizon at 2025-09-08T20:42:50"]),
        ({"target": {"constrain": {"body": Z, "toward": "velocity"}}},
         ["its body axis stands 0 deg from"]),
        ({"target": {"align": NADIR, "constrain": {"body": X, "direction_orbit": Z}}},
         ["stands 0 deg from the nadir", "roll to chance"]),
        ({"target": {"constrain": {"body": X, "toward": "satellite"}}}, ["satellite: missing"]),
        ({"target": {"rate": "tracking"}}, ['did you mean \'track\'']),
        ({"target": {"rate_rad_s": [0.0, 0.0, 0.0]}}, ["rate", "given beside rate_rad_s"]),
        ({"initial": {"align": GONE, "constrain": GONE, "attitude_deg": [0, 0, 0],
                      "rate": "track"}}, ["there is nothing to track"]),
        ({"target": {"constrain": {"body": X, "toward": "sun"}}, "orbit": {
            "tle": GONE, "epoch": GONE, "semi_major_axis_km": 6852.2, "eccentricity": 0.002,
            "inclination_deg": 97.4, "raan_deg": 280.0, "argument_of_periapsis_deg": 0.0,
            "true_anomaly_deg": 0.0}}, ["needs the date", "epoch"]),
    ],
)  # fmt: skip
def test_odd_aims_are_refused_with_a_sentence(tables, words):
    with pytest.raises(ScenarioError) as caught:
        read(**tables)
    message = str(caught.value)
    assert "s.toml" in message and "; " in message
    for each in words:
        assert each in message, message


def test_degrees_that_look_like_radians_are_noted():
    place = {**SITE, "latitude_deg": 1.1069, "longitude_deg": 0.1813}
    noted = read(orbit={"epoch": "2025-09-08T21:58:50Z"}, target={"align": place})
    assert [note for note in noted.notes if "as radians they would be 63.42 and 10.39" in note]


def test_what_may_be_behind_a_place_out_of_sight_is_said():
    place = {**SITE, "latitude_deg": 1.1069, "longitude_deg": 0.1813}
    with pytest.raises(ScenarioError, match=r"out of sight.*as radians they would be 63\.42 and"):
        read(target={"align": place})
    with pytest.raises(ScenarioError, match=r"out of sight.*42\.9 days old .* off by about"):
        read(orbit={"epoch": "2025-10-20T20:41:40Z"})
    with pytest.raises(ScenarioError, match="out of sight") as caught:
        read(target={"align": {**SITE, "latitude_deg": -3.0, "longitude_deg": 2.0}})
    assert "radians" not in str(caught.value) and "days old" not in str(caught.value)
