"""`jaxatt orbit`: ground track, light, sun and field of an orbit, against skyfield and astropy."""

import datetime as dt
import json
import warnings

import numpy as np
import pytest
from references.public_orbits import HYPSO1
from typer.testing import CliRunner

import jaxatt
from jaxatt.cli import app
from jaxatt.environment import epoch
from jaxatt.scenarios import ScenarioError


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("orbits") / "hypso.tle"
    path.write_text("\n".join(["HYPSO-1", *HYPSO1]))
    return path


@pytest.fixture(scope="module")
def found(file):
    return jaxatt.orbit_course(file, 4.0)


@pytest.fixture(scope="module")
def moments(found):
    start = epoch.J2000 + dt.timedelta(days=found.course.known.orbit.days)
    return [start + dt.timedelta(seconds=float(time)) for time in found.course.times]


def test_the_ground_track_is_that_of_skyfield(found, moments):
    skyfield = pytest.importorskip("skyfield.api")
    scale = skyfield.load.timescale(builtin=True)
    there = skyfield.EarthSatellite(*HYPSO1, "x", scale).at(scale.from_datetimes(moments))
    below = skyfield.wgs84.geographic_position_of(there)
    course = found.course
    # Universal time is up to 0.9 s from UTC, which is 0.004 deg of longitude.
    east = (np.degrees(course.longitude) - below.longitude.degrees + 180.0) % 360.0 - 180.0
    assert np.abs(east).max() < 0.01
    assert np.abs(np.degrees(course.latitude) - below.latitude.degrees).max() < 0.001
    assert np.abs(course.altitude - below.elevation.m).max() < 20.0
    assert np.ptp(np.degrees(course.latitude)) > 160.0


def test_beta_and_light_are_those_of_the_sun_of_astropy(found, moments):
    course = found.course
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from astropy.coordinates import get_sun
        from astropy.time import Time

        time = Time([moment.replace(tzinfo=None) for moment in moments], scale="utc")
        sun = get_sun(time).cartesian.xyz.to_value("m").T
    away = sun / np.linalg.norm(sun, axis=1)[:, None]
    assert np.degrees(np.linalg.norm(away - course.sun, axis=1)).max() < 0.005
    normal = np.cross(course.position, course.velocity)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    expected = np.degrees(np.arcsin(np.sum(normal * away, axis=1)))
    np.testing.assert_allclose(np.degrees(course.beta), expected, atol=0.01)
    # Behind the Earth: within its radius of the line from the sun, on the far side.
    along = np.sum(course.position * away, axis=1)
    off = np.linalg.norm(course.position - along[:, None] * away, axis=1)
    clear = np.abs(off - 6378137.0) > 40e3
    dark = (along < 0.0) & (off < 6378137.0)
    assert (dark[clear] == (course.light[clear] < 0.5)).all() and dark[clear].any()
    assert found.to_dict()["eclipse_percent"] == pytest.approx(100.0 * dark.mean(), abs=1.5)
    assert 0.0 < found.to_dict()["longest_eclipse_s"] < 2200.0


def test_files_hold_what_was_found(found, tmp_path):
    files = found.save(tmp_path)
    assert [path.name for path in files] == ["orbit.nc", "orbit.png", "summary.json"]
    import xarray

    with xarray.open_dataset(tmp_path / "orbit.nc", engine="h5netcdf") as archive:
        np.testing.assert_array_equal(archive.position, found.course.position)
        assert archive.field.attrs["units"] == "T"
        assert archive.attrs["days_since_j2000"] == pytest.approx(found.course.known.orbit.days)
    numbers = json.loads((tmp_path / "summary.json").read_text())
    assert numbers["title"] == "HYPSO-1 (51053)" and len(numbers["eclipses"]) == 3
    assert numbers["mean_elements"]["mean_motion_rev_day"] == pytest.approx(15.45768954)
    assert "HYPSO-1 (51053)" in str(found) and "mean elements (SGP4" in str(found)


def run(*arguments):
    return CliRunner().invoke(app, ["orbit", *map(str, arguments)])


def test_the_command_says_how_old_the_elements_are(file, tmp_path):
    found = run(file, "--hours", "4", "--epoch", "2025-09-20T00:00:00Z", "--out", tmp_path)
    assert found.exit_code == 0, found.output
    assert "12.1 days old" in found.output.replace("\n", " ")
    assert (tmp_path / "orbit.nc").exists()


def test_bad_input_ends_in_a_sentence(file, tmp_path):
    wrong = tmp_path / "wrong.tle"
    wrong.write_text("\n".join([HYPSO1[0].replace("44933", "44934"), HYPSO1[1]]))
    other = tmp_path / "other.txt"
    other.write_text("no orbit")
    for arguments, said in (
        ((wrong,), "checksum of line 1"),
        ((other,), "is no orbit that is known"),
        ((tmp_path / "nothing.tle",), "cannot be read"),
        ((file, "--epoch", "2060-01-01"), "Earth's radius"),
        ((file, "--object", "ISS"), 'no object "ISS"'),
        (("hypso1-90-45-15",), "--epoch"),
        (("mrp-k4",), "[orbit]"),
    ):
        found = run(*arguments, "--out", tmp_path / "out")
        assert found.exit_code == 2 and "Traceback" not in found.output
        assert said in " ".join(found.output.split())


def test_other_dates_and_no_end():
    with pytest.raises(ScenarioError, match="fewer hours"):
        jaxatt.orbit_course("hypso1-tle-90-45-15", 1e5)
