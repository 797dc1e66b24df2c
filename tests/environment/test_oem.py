"""Orbit ephemeris messages: states between those of a file, frames, time systems and gaps."""

import datetime as dt

import numpy as np
import pytest

from jaxatt.environment import epoch, precession
from jaxatt.environment.orbit_data.formats import kind_of, read_orbit_file
from jaxatt.environment.orbit_data.j2 import Propagation, pole_of_date
from jaxatt.environment.orbit_data.oem import read_oem
from jaxatt.environment.orbit_data.oem_rows import check_rows
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.environment.teme import from_teme, inertial_of_earth_fixed

START = dt.datetime(2025, 9, 8, tzinfo=dt.UTC)
DAYS = epoch.days_since_j2000(START)
# SGP4's velocities are not quite the derivatives of its positions; an integrated orbit's are.
STATES = Propagation(
    np.array([-3511670.2, 2046527.8, 5455090.3]),
    np.array([-4508.9, 4493.7, -4586.4]),
    pole_of_date(DAYS),
)
AHEAD = {"UTC": 0.0, "TAI": 37.0, "TT": 69.184}
"""[s] By which a time system is ahead of UTC in 2025."""


def message(times, r, v, frame="EME2000", scale="UTC", center="EARTH", usable=None):
    """Text of one segment with the states r [m] and v [m/s] at times [s] in UTC after START."""

    def moment(time):
        later = dt.timedelta(seconds=float(time) + AHEAD.get(scale, 0.0))
        return f"{START + later:%Y-%m-%dT%H:%M:%S.%f}"

    about = {
        "OBJECT_NAME": "HYPSO-1",
        "OBJECT_ID": "2022-002BX",
        "CENTER_NAME": center,
        "REF_FRAME": frame,
        "TIME_SYSTEM": scale,
        "START_TIME": moment(times[0]),
    }
    if usable is not None:
        about |= {"USEABLE_START_TIME": moment(usable[0]), "USEABLE_STOP_TIME": moment(usable[1])}
    about["STOP_TIME"] = moment(times[-1])
    rows = [
        " ".join([moment(t), *(f"{x:.9f}" for x in 1e-3 * a), *(f"{x:.12f}" for x in 1e-3 * b)])
        for t, a, b in zip(times, r, v, strict=True)
    ]
    lines = ["META_START", *(f"{k} = {x}" for k, x in about.items()), "META_STOP", "", *rows, ""]
    return "\n".join(lines)


HEAD = "CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2025-09-08T00:00:00\nORIGINATOR = NOBODY\n\n"


def written(folder, *messages, name="orbit.oem"):
    path = folder / name
    path.write_text(HEAD + "\n".join(messages))
    return path


def teme(times):
    turn = np.asarray(from_teme(DAYS + times / 86400.0))
    return tuple(np.einsum("nji,nj->ni", turn, part) for part in STATES(times))


def earth_fixed(times):
    """States of the same orbit as the turning Earth sees them: the inverse, by differences."""

    def place(later):
        turn = np.asarray(precession.earth_fixed(DAYS + (times + later) / 86400.0))
        return np.einsum("nij,nj->ni", turn, STATES(times + later)[0])

    return place(0.0), (place(0.5) - place(-0.5)) / 1.0


@pytest.mark.parametrize("scale", AHEAD)
@pytest.mark.parametrize("step", [10.0, 60.0, 300.0])
def test_between_the_states_of_a_file(tmp_path, step, scale):
    """Within a centimetre of the orbit it was made from, up to the ends; beyond them by J2."""
    times = np.arange(0.0, 5401.0, step)
    path = written(tmp_path, message(times, *STATES(times), scale=scale))
    assert kind_of(path.read_text()) == "oem"
    found = read_oem(path)
    assert found.title == "HYPSO-1 (2022-002BX)"
    assert found.epoch == pytest.approx(DAYS, abs=1e-9)
    own = np.random.default_rng(3).uniform(0.0, 5400.0, 200)
    # Another start than the file's: two of its minutes later.
    r, v = found.over(DAYS + 120.0 / 86400.0, -120.0, 5280.0)(own - 120.0)
    r_too, v_too = STATES(own)
    assert np.linalg.norm(r - r_too, axis=1).max() < 0.01
    assert np.linalg.norm(v - v_too, axis=1).max() < 5e-4
    beyond = np.array([-100.0, 5500.0])
    r, _ = found.over(DAYS, 0.0, 5400.0)(beyond)
    assert np.linalg.norm(r - STATES(beyond)[0], axis=1).max() < 1e-3


@pytest.mark.parametrize(
    ("frame", "states", "allowed"),
    [("TEME", teme, 0.01), ("ITRF2014", earth_fixed, 0.02), ("GCRF", STATES, 0.01)],
)
def test_frames_of_files(tmp_path, frame, states, allowed):
    times = np.arange(0.0, 3001.0, 60.0)
    found = read_oem(written(tmp_path, message(times, *states(times), frame=frame)))
    own = np.random.default_rng(4).uniform(0.0, 3000.0, 100)
    r, v = found.over(DAYS, 0.0, 3000.0)(own)
    r_too, v_too = STATES(own)
    assert np.linalg.norm(r - r_too, axis=1).max() < allowed
    assert np.linalg.norm(v - v_too, axis=1).max() < 1e-2


def test_xml_and_a_copy_are_the_same_orbit(tmp_path):
    from oem import OrbitEphemerisMessage

    times = np.arange(0.0, 3001.0, 60.0)
    path = written(tmp_path, message(times, *STATES(times)))
    OrbitEphemerisMessage.open(path).save_as(tmp_path / "orbit.xml", file_format="xml")
    own = np.linspace(0.0, 3000.0, 17)
    r, _ = read_oem(path).over(DAYS, 0.0, 3000.0)(own)
    r_too, _ = read_orbit_file(tmp_path / "orbit.xml", "oem").over(DAYS, 0.0, 3000.0)(own)
    np.testing.assert_allclose(r, r_too, rtol=0.0, atol=1e-4)


def test_a_gap_is_refused_with_its_times(tmp_path):
    times = np.arange(0.0, 7201.0, 60.0)
    kept = times[(times < 3000.0) | (times > 3400.0)]
    inside = written(tmp_path, message(kept, *STATES(kept)))
    parts = [
        message(some, *STATES(some)) for some in (times[times < 2950.0], times[times > 3400.0])
    ]
    between = written(tmp_path, *parts, name="two.oem")
    for path in (inside, between):
        found = read_oem(path)
        found.over(DAYS, 0.0, 2900.0)
        found.over(DAYS, 3500.0, 7200.0)
        with pytest.raises(
            OrbitDataError, match=r"T00:49:00Z; 2025-09-08T00:57:00Z to .*; begin at"
        ):
            found.over(DAYS, 2800.0, 3600.0)
    with pytest.raises(OrbitDataError, match="give a file that covers it"):
        found.over(DAYS, 7000.0, 7300.0)
    with pytest.raises(OrbitDataError, match="2025-09-07T23:59:00Z to"):
        found.over(DAYS, -60.0, 10.0)


def test_only_the_usable_part_of_a_segment_is_used(tmp_path):
    times = np.arange(0.0, 3001.0, 60.0)
    found = read_oem(written(tmp_path, message(times, *STATES(times), usable=(300.0, 2700.0))))
    found.over(DAYS, 300.0, 2700.0)
    with pytest.raises(OrbitDataError, match="not within states"):
        found.over(DAYS, 240.0, 2000.0)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"frame": "RTN"}, "REF_FRAME is RTN, which is not known; .*EME2000.*TEME"),
        ({"center": "MARS BARYCENTER"}, "CENTER_NAME is MARS"),
        ({"scale": "GPS"}, "TIME_SYSTEM is GPS, which is not known; .*UTC"),
    ],
)
def test_files_that_cannot_be_placed_are_refused(tmp_path, changes, said):
    times = np.arange(0.0, 601.0, 60.0)
    with pytest.raises(OrbitDataError, match=said):
        read_oem(written(tmp_path, message(times, *STATES(times), **changes)))


def test_metres_are_not_taken_for_kilometres(tmp_path):
    times = np.arange(0.0, 601.0, 60.0)
    r, v = STATES(times)
    for scale in (1e3, 1e-3):
        with pytest.raises(OrbitDataError, match="on no orbit; give kilometres"):
            read_oem(written(tmp_path, message(times, scale * r, scale * v)))


def test_broken_files_are_refused(tmp_path):
    times = np.arange(0.0, 601.0, 60.0)
    good = message(times, *STATES(times))
    for text in (good.replace("META_STOP", "META"), good.replace("EARTH", ""), "no ephemeris"):
        with pytest.raises(OrbitDataError, match="; "):
            read_oem(written(tmp_path, text))
    with pytest.raises(OrbitDataError, match="holds an orbit as OEM, not as TLE; use oem_file"):
        read_orbit_file(written(tmp_path, good), "tle")
    with pytest.raises(OrbitDataError, match=r"cannot be read .*; check the path"):
        read_orbit_file(tmp_path / "nothing.oem", "oem")


def _row(text, number, change):
    """The text with the words of a row changed, counted from the first state."""
    lines = text.split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("2025"))
    words = lines[first + number].split()
    lines[first + number] = " ".join(change(words, lines[first + number - 1].split()))
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda row, above: above, r"line 18: 2025-\S+ follows 2025-\S+; .*sort its rows"),
        (lambda row, above: [above[0], *row[1:]], "line 18: .*drop repeated ones"),
        (lambda row, above: [row[0].replace("-08T", "-07T"), *row[1:]], "line 18: .*must increase"),
        (lambda row, above: [row[0].replace("-09-", "-19-"), *row[1:]], "line 18: .* is no moment"),
        (lambda row, above: row[:-1], "line 18: has 5 numbers behind its epoch, not 6"),
        (lambda row, above: [*row[:2], "nan", *row[3:]], "line 18: nan is no number; correct"),
    ],
)
def test_a_row_that_is_wrong_is_named_by_its_line(tmp_path, change, said):
    times = np.arange(0.0, 601.0, 60.0)
    path = written(tmp_path, _row(message(times, *STATES(times)), 3, change))
    assert path.read_text().splitlines()[17].startswith("2025")
    with pytest.raises(OrbitDataError, match=said):
        read_oem(path)


def test_a_state_in_xml_is_named_by_its_epoch():
    names = ("X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
    numbers = "".join(f'<{name} units="u">1.5e+0</{name}>' for name in names)
    states = [
        f"<stateVector><EPOCH>2025-09-08T00:0{k}:00</EPOCH>{numbers}</stateVector>"
        for k in range(3)
    ]
    text = f'<oem xmlns="urn:ccsds"><segment>{"".join(states)}</segment></oem>'
    check_rows(text)
    for old, new, said in (
        (states[1], states[1].replace("1.5e+0</Y>", "x</Y>"), "the state of .*:01:00: x is no num"),
        (states[1], states[2], "the state of .*:02:00: .* follows .*:02:00"),
        ("<Z_DOT", "<OTHER><Z_DOT", "is no XML"),
        ("<oem", "<!DOCTYPE oem><oem", "declares entities of its own; leave them out"),
    ):
        assert old in text
        with pytest.raises(OrbitDataError, match=said):
            check_rows(text.replace(old, new))


def test_segments_and_keywords_that_are_wrong_are_named(tmp_path):
    times = np.arange(0.0, 601.0, 60.0)
    good = message(times, *STATES(times))
    for text, said in (
        (f"{good}\n{good}", "a segment begins at .* before the one above it ends"),
        (good.replace("REF_FRAME = EME2000\n", ""), "line 12: REF_FRAME is missing above"),
        (good[good.index("META_STOP") + 9 :], "line 7: .* has no place in an OEM before META_S"),
    ):
        with pytest.raises(OrbitDataError, match=said):
            read_oem(written(tmp_path, text))


def test_velocities_seen_on_the_turning_earth():
    times = np.linspace(0.0, 5000.0, 11)
    r, v = inertial_of_earth_fixed(DAYS + times / 86400.0, *earth_fixed(times))
    r_too, v_too = STATES(times)
    np.testing.assert_allclose(r, r_too, rtol=0.0, atol=1e-3)
    np.testing.assert_allclose(v, v_too, rtol=0.0, atol=5e-3)


def test_how_long_states_go_on(tmp_path):
    times = np.arange(0.0, 1201.0, 60.0)
    parts = (times[:10], times[13:])
    table = read_oem(written(tmp_path, *(message(part, *STATES(part)) for part in parts)))
    for after, known in ((0.0, 540.0), (500.0, 40.0), (600.0, 0.0), (800.0, 400.0), (1300.0, 0.0)):
        assert table.lasts(DAYS + after / 86400.0) == pytest.approx(known, abs=1e-4)
