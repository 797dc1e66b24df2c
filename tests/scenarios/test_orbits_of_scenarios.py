"""The table [orbit] of scenarios and flights: TLE, OMM and OEM, J2, and what is refused."""

import copy
import json
import tomllib

import jax
import numpy as np
import pytest
from references.public_orbits import HYPSO1
from references.short_flights import flight
from sgp4.exporter import export_omm

from jaxatt import scenarios
from jaxatt.environment import epoch, frames, ground
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.orbit_data.tle import element_set
from jaxatt.environment.table import environment_at
from jaxatt.problems.net_power.plan.sight import positions_over_ground
from jaxatt.problems.reading.orbit import covering, on_date, read_orbit
from jaxatt.problems.surroundings import motion_of, surroundings_of
from jaxatt.scenarios import ScenarioError
from jaxatt.scenarios.flight_build import build_flight

CASE = tomllib.loads(scenarios.text("hypso1-tle-90-45-15"))
ELEMENTS = tomllib.loads(scenarios.text("hypso1-90-45-15"))["orbit"]
PLAN = tomllib.loads(scenarios.text("hypso2-orbit"))
SET = element_set(HYPSO1)
at = jax.jit(environment_at)
below = jax.jit(lambda r, days: ground.point_below(ground.earth_fixed(r, days)))
elevation, quaternion_io = jax.jit(ground.elevation), jax.jit(frames.quaternion_io)
omega_io = jax.jit(frames.omega_io)
follow = jax.jit(lambda motion, times: motion.at(times))


def with_orbit(orbit, document=CASE, folder=None, **tables):
    changed = copy.deepcopy(document) | copy.deepcopy(tables)
    changed["orbit"] = orbit
    return scenarios.from_mapping(changed, origin="case.toml", folder=folder)


def refusal(orbit, folder=None, **tables):
    with pytest.raises(ScenarioError) as caught:
        with_orbit(orbit, folder=folder, **tables)
    message = str(caught.value)
    assert message.startswith("case.toml: ") and "; " in message
    return message


@pytest.fixture(scope="module")
def bundled():
    return scenarios.load("hypso1-tle-90-45-15")


def test_a_scenario_flies_on_the_orbit_of_its_elements(bundled):
    times = np.linspace(0.0, 98.0, 15)
    found = at(surroundings_of(bundled), times)
    r, v = SET.over(bundled.orbit.days, 0.0, 98.0)(times)
    q = np.asarray(quaternion_io(r, v))
    assert np.abs(np.sum(q * np.asarray(found.orbit_attitude), axis=1)).min() > 1.0 - 1e-12
    np.testing.assert_allclose(found.orbit_rate[:, 1], omega_io(r, v)[:, 1], rtol=1e-7)
    assert np.abs(found.orbit_rate[:, 2]).max() > 1e-8
    radius = np.linalg.norm(r, axis=1)
    np.testing.assert_allclose(found.gradient, 3.0 * 3.986004418e14 / radius**3, rtol=1e-7)
    assert bundled.notes == ()
    assert bundled.orbit.inclination == pytest.approx(np.radians(97.3), abs=5e-3)


def test_every_source_is_the_same_orbit(bundled, tmp_path):
    epoch_text = CASE["orbit"]["epoch"]
    (tmp_path / "hypso.tle").write_text("\n".join(["HYPSO-1", *HYPSO1]))
    (tmp_path / "hypso.json").write_text(json.dumps([export_omm(SET.satrec, "HYPSO-1")]))
    times = np.linspace(0.0, 98.0, 5)
    expected = follow(motion_of(bundled.orbit), times).position
    for orbit in (
        {"tle_file": "hypso.tle", "object": "51053"},
        {"omm_file": "hypso.json", "object": "HYPSO-1"},
        {"tle_file": str(tmp_path / "hypso.tle")},
    ):
        case = with_orbit({**orbit, "epoch": epoch_text}, folder=tmp_path)
        found = follow(motion_of(case.orbit), times).position
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=0.05)


def test_without_an_epoch_it_starts_at_that_of_the_elements():
    case = with_orbit({"tle": list(HYPSO1)})
    assert case.orbit.days == pytest.approx(SET.epoch, abs=1e-12)
    assert case.notes == ("starts at the epoch of its orbit, 2025-09-07T22:41:18Z",)
    (note,) = with_orbit({"tle": list(HYPSO1), "epoch": "2025-09-28T00:00:00Z"}).notes
    assert "20.1 days old" in note and "km" in note


def test_j2_with_osculating_and_with_mean_elements():
    plain = with_orbit(ELEMENTS).orbit
    oblate = with_orbit({**ELEMENTS, "perturbations": "J2"}).orbit
    mean = with_orbit({**ELEMENTS, "perturbations": "J2", "elements": "mean"}).orbit
    names = ("semi_major_axis", "eccentricity", "inclination", "raan")
    for name in names:
        assert getattr(oblate, name) == pytest.approx(getattr(plain, name), rel=1e-9)
    assert abs(mean.semi_major_axis - plain.semi_major_axis) > 100.0
    starts = [follow(motion_of(orbit), np.zeros(1)).position for orbit in (plain, oblate)]
    np.testing.assert_allclose(*starts, rtol=0.0, atol=1e-3)
    later = [follow(motion_of(orbit), np.full(1, 98.0)).position for orbit in (plain, oblate)]
    # Half of 1.4e-2 m/s^2, which is J2 in a low orbit, times the square of the time.
    assert 10.0 < np.linalg.norm(later[0] - later[1]) < 200.0


def test_a_flight_on_a_tle():
    orbit = dict.fromkeys([*ELEMENTS, "gravitational_parameter_m3_s2"])
    case = flight(
        orbit={**orbit, "tle": list(HYPSO1)}, environment={"epoch": "2025-09-08T10:20:00Z"}
    )
    r, v = SET.over(case.surroundings.days, 0.0, 60.0)(np.linspace(0.0, 60.0, 2))
    nodes = build_flight(case)[0].ends[0]
    found, expected = (
        np.asarray(nodes.attitude.array)[-1],
        np.asarray(quaternion_io(r, v))[-1],
    )
    assert abs(found @ expected) > 1.0 - 1e-12
    undated = flight(orbit={**orbit, "tle": list(HYPSO1)})
    assert undated.surroundings.days == pytest.approx(SET.epoch)
    with pytest.raises(ScenarioError, match=r"\[orbit\] epoch: a flight has it"):
        flight(orbit={**orbit, "tle": list(HYPSO1), "epoch": "2025-09-08T10:20:00Z"})


def test_places_are_looked_at_from_the_orbit_of_a_tle():
    """The place below is at the zenith's foot, and one a quarter of the Earth away out of sight."""
    when = {"tle": list(HYPSO1), "epoch": "2025-09-08T10:20:00Z"}
    days = epoch.days_since_j2000(epoch.parse(when["epoch"]))
    r, _ = SET.over(days, 0.0, 900.0)(np.array([660.0]))
    latitude, longitude = (float(part[0]) for part in below(r, np.array([days + 660.0 / 86400.0])))
    target = [np.degrees(latitude), np.degrees(longitude) + 90.0]
    look = {"attitude_quaternion": [1.0, 0.0, 0.0, 0.0], "frame": "orbit", "target_deg": target}
    tasks = [
        {"name": "sun", "mode": "harvest", "duration_s": 600.0},
        {"name": "down", "mode": "communicate", "start": "10:30:00", "duration_s": 120.0, **look},
    ]
    document = {key: value for key, value in PLAN.items() if key not in ("horizon", "printed")}
    with pytest.raises(ScenarioError, match=r'no. 2 "down" .* out of sight: .* at 10:3'):
        with_orbit(when, document, tasks=tasks)
    # The position over the ground that the check has found is that of the theory.
    orbit = covering(read_orbit(when, "test", None, []), when, "test", 900.0)
    flown = OrbitTask(motion_of(orbit), days)
    above = positions_over_ground(flown, np.linspace(600.0, 720.0, 61))
    angle = elevation(above, latitude, longitude)
    assert np.degrees(angle[30]) > 89.9 and np.degrees(angle.min()) < 60.0


@pytest.mark.parametrize(
    ("orbit", "parts"),
    [
        ({"tle": [HYPSO1[0], HYPSO1[1][:-1] + "0"]}, ["[orbit] tle", "checksum of line 2"]),
        ({"tle": HYPSO1[0]}, ["must be a list of texts", '["1 ...", "2 ..."]']),
        ({"tle": list(HYPSO1), "raan_deg": 3.0}, ["raan_deg = 3.0", "given beside tle"]),
        (
            {"tle": list(HYPSO1), "epoch": "2045-01-01"},
            ["more than the Earth's radius"],
        ),
        ({"tle_file": "nothing.tle"}, ['tle_file = "nothing.tle"', "cannot be read"]),
        ({**ELEMENTS, "elements": "mean"}, ["no mean elements", 'perturbations = "J2"']),
        ({**ELEMENTS, "perturbations": "J3"}, ["perturbations", "allowed: none, J2"]),
        ({**ELEMENTS, "object": "ISS"}, ["object", "no file"]),
        ({"tle_files": "a"}, ["'tle_file'"]),
    ],
)
def test_what_is_refused(orbit, parts):
    message = refusal(orbit)
    for part in parts:
        assert part in message


def test_an_orbit_is_not_sampled_for_ever():
    horizon = {**CASE["horizon"], "final_time": "free"}
    message = refusal(CASE["orbit"], horizon=horizon)
    assert "longest_s" in message
    with_orbit(CASE["orbit"], horizon={**horizon, "longest_s": 90.0})


def test_an_oblate_orbit_goes_on_to_the_dates():
    table = dict(scenarios.load("hypso2-orbit").document["orbit"])
    ellipse = read_orbit(table, "test", None, [])
    moved = on_date(ellipse, table, "test", None, [], ellipse.days + 2.5)
    assert (moved.raan, moved.days) == (ellipse.raan, ellipse.days + 2.5)
    table["perturbations"] = "J2"
    first = read_orbit(table, "test", None, [])
    later = on_date(first, table, "test", None, [], first.days + 1.0)
    again = on_date(later, table, "test", None, [], first.days + 2.5)
    at_once = on_date(first, table, "test", None, [], first.days + 2.5)
    for name in ("raan", "inclination", "semi_major_axis"):
        assert getattr(again, name) == pytest.approx(getattr(at_once, name), rel=1e-9)
    # Sun-synchronous: the node goes on by a degree a day.
    assert np.rad2deg(again.raan - first.raan) == pytest.approx(2.5, abs=0.2)
