"""Attitude files as the start of a manoeuvre and as the reference of a flight."""

import datetime as dt

import numpy as np
import pytest
from references import short_flights
from references.attitude_histories import EPOCH, turning
from scipy.spatial.transform import Rotation

from jaxatt import scenarios
from jaxatt.exchange.aem import aem_text
from jaxatt.exchange.motion import Named
from jaxatt.problems.along_orbit import along_orbit
from jaxatt.problems.surroundings import motion_of
from jaxatt.scenarios import ScenarioError, flight_from_mapping

HISTORY = turning(5, count=241, step=0.5)
AT = (EPOCH + dt.timedelta(seconds=30.0)).isoformat()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "start.aem"
    path.write_text(aem_text([HISTORY], Named("A")), encoding="utf-8")
    return str(path)


def begun(name, initial, **changes):
    document = {**dict(scenarios.load(name).document), **changes}
    speeds = document["initial"].get("wheel_speed_rad_s")
    document["initial"] = initial | ({} if speeds is None else {"wheel_speed_rad_s": speeds})
    return scenarios.from_mapping(document)


def test_a_slew_starts_relative_to_the_orbit_frame_as_the_file_says(file) -> None:
    scenario = begun("hypso1-90-45-15", {"aem_file": file, "at": AT})
    frame = along_orbit(motion_of(scenario.orbit), np.zeros(1))
    r_io = Rotation.from_quat(frame.q_io, scalar_first=True)
    r_ob = Rotation.from_quat(scenario.initial.q_ob, scalar_first=True)
    r_ib = Rotation.from_quat(HISTORY.q_ib[60], scalar_first=True)
    assert ((r_io * r_ob).inv() * r_ib).magnitude() < 1e-12
    rate = scenario.initial.omega_ob + r_ob.inv().apply(np.array(frame.omega_io[0]))
    np.testing.assert_allclose(rate, HISTORY.omega_ib[60], atol=1e-12)
    assert np.linalg.norm(scenario.initial.omega_ob) > 1e-3


@pytest.mark.parametrize("name", ["mrp-k4", "hypso1-netpower"])
def test_turns_in_inertial_axes_start_as_the_file_says(file, name) -> None:
    scenario = begun(name, {"aem_file": file, "at": AT})
    np.testing.assert_allclose(scenario.initial.q_ob, HISTORY.q_ib[60], atol=1e-12)
    np.testing.assert_allclose(scenario.initial.omega_ob, HISTORY.omega_ib[60], atol=1e-12)


def test_the_epoch_of_the_orbit_is_the_moment_in_the_file(file) -> None:
    orbit = {**scenarios.load("hypso1-90-45-15").document["orbit"], "epoch": AT}
    dated = begun("hypso1-90-45-15", {"aem_file": file}, orbit=orbit)
    other = begun("hypso1-90-45-15", {"aem_file": file, "at": AT})
    np.testing.assert_allclose(dated.initial.q_ob, other.initial.q_ob, atol=1e-8)


def test_another_attitude_replaces_the_file_and_back(file) -> None:
    scenario = begun("hypso1-90-45-15", {"aem_file": file, "at": AT})
    changed = scenarios.replace(scenario, {"initial.attitude_deg": [0.0, 0.0, 0.0]})
    np.testing.assert_array_equal(changed.initial.q_ob, [1.0, 0.0, 0.0, 0.0])
    again = scenarios.replace(changed, {"initial.aem_file": file, "initial.at": AT})
    np.testing.assert_array_equal(again.initial.q_ob, scenario.initial.q_ob)


@pytest.mark.parametrize(
    "initial, words",
    [
        ({}, "at: missing, and there is no epoch"),
        ({"at": "noon"}, 'at = "noon": is no moment'),
        ({"at": "2026-06-22T12:00:00Z"}, "is asked for 2026-06-22T12:00:00.000Z"),
        ({"at": AT, "rate_rad_s": [0.0, 0.0, 0.0]}, "rate_rad_s.*beside aem_file"),
        ({"at": AT, "attitude_deg": [0.0, 0.0, 0.0]}, "attitude_deg.*beside aem_file"),
    ],
)
def test_bad_starts_say_what_to_do(file, initial, words) -> None:
    with pytest.raises(ScenarioError, match=words):
        begun("hypso1-90-45-15", {"aem_file": file, **initial})


def test_a_missing_file_and_a_lone_moment(tmp_path) -> None:
    with pytest.raises(ScenarioError, match=r"\[initial\] aem_file = .*cannot be read"):
        begun("hypso1-90-45-15", {"aem_file": str(tmp_path / "no.aem"), "at": AT})
    with pytest.raises(ScenarioError, match=r"at = .*given without aem_file"):
        begun("hypso1-90-45-15", {"attitude_deg": [0.0, 0.0, 0.0], "at": AT})


def flying(reference, duration=60.0, **changes):
    return short_flights.flight(
        reference={"attitude_deg": None, **reference},
        environment={"epoch": AT},
        simulation={"duration_s": duration},
        **changes,
    )


def test_a_flight_that_the_file_does_not_cover_is_refused(file) -> None:
    assert flying({"aem_file": file}).asked.path is not None
    with pytest.raises(ScenarioError, match=r"12:00:28\.250Z to 2026-06-21T12:02:08\.250Z; it has"):
        flying({"aem_file": file}, duration=100.0)
    flying({"aem_file": file, "at": EPOCH.isoformat()}, duration=100.0)


@pytest.mark.parametrize(
    "reference, words",
    [
        ({"manoeuvre": "hypso1-90-45-15"}, "manoeuvre.*beside aem_file"),
        ({"rate_rad_s": [0.0, 0.0, 0.1]}, "rate_rad_s.*beside aem_file"),
        ({"attitude_held": False}, "attitude_held.*beside aem_file"),
    ],
)
def test_bad_references_say_what_to_do(file, reference, words) -> None:
    with pytest.raises(ScenarioError, match=words):
        flying({"aem_file": file, **reference})


def test_files_are_looked_up_beside_the_scenario(file, tmp_path) -> None:
    document = dict(flying({"aem_file": file}).document)
    document["reference"] = {"aem_file": "start.aem"}
    assert flight_from_mapping(document, folder=tmp_path).asked.path is not None
