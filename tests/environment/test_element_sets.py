"""Element sets of SGP4 against skyfield, which turns TEME by the full nutation."""

import datetime as dt

import jax
import numpy as np
import pytest
from references.public_orbits import HYPSO1, REPORT

from jaxatt.environment import epoch
from jaxatt.environment.ephemeris import TOLERANCE, sampled
from jaxatt.environment.nutation import nutation
from jaxatt.environment.orbit_data.element_set import ElementSet, choose
from jaxatt.environment.orbit_data.formats import kind_of
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.environment.orbit_data.tle import element_set, read_tle

WEEK = 7.0 * 86400.0
SETS = (HYPSO1, *REPORT)
at = jax.jit(lambda ephemeris, times: ephemeris.at(times))


def checksummed(line):
    digits = sum(int(c) if c.isdigit() else c == "-" for c in line[:68])
    return f"{line[:68]}{digits % 10}"


@pytest.mark.parametrize("lines", SETS, ids=["hypso", "vanguard", "molniya", "geostationary"])
def test_positions_are_those_of_skyfield(lines):
    skyfield = pytest.importorskip("skyfield.api")
    scale = skyfield.load.timescale(builtin=True)
    other = skyfield.EarthSatellite(*lines, "x", scale)
    own = element_set(lines)
    times = np.random.default_rng(11).uniform(-0.5 * WEEK, 0.5 * WEEK, 400)
    r, v = own.over(own.epoch, 0.0, 0.0)(times)
    start = epoch.J2000 + dt.timedelta(days=own.epoch)
    moments = scale.from_datetimes([start + dt.timedelta(seconds=float(t)) for t in times])
    expected = other.at(moments)
    assert np.linalg.norm(r, axis=1).max() > 6.5e6
    # The celestial frame is 0.023 arcsec from that of J2000: 0.8 m in a low orbit, 5 m in the last.
    bound = 1.5e-7 * np.linalg.norm(r, axis=1)
    assert (
        np.linalg.norm(1e3 * expected.position.km.T - r, axis=1) < np.minimum(bound, 10.0)
    ).all()
    assert np.linalg.norm(1e3 * expected.velocity.km_per_s.T - v, axis=1).max() < 2e-3
    _, inside, _ = own.satrec.sgp4_array(*_julian(own.epoch, times))
    np.testing.assert_allclose(np.linalg.norm(r, axis=1), 1e3 * np.linalg.norm(inside, axis=1))


def _julian(days, times):
    whole = np.floor(days)
    return np.full(len(times), 2451545.0 + whole), days - whole + times / 86400.0


def test_nutation_is_that_of_the_full_series():
    erfa = pytest.importorskip("erfa")
    days = np.random.default_rng(12).uniform(-3652.0, 12784.0, 500)  # 1990 to 2035
    found = jax.jit(nutation)(days)
    longitude, obliquity = erfa.nut06a(2451545.0, days)
    arcsec = np.deg2rad(1.0 / 3600.0)
    assert np.abs(longitude).max() > 10.0 * arcsec
    assert np.abs(found.longitude - longitude).max() < 0.05 * arcsec
    assert np.abs(found.obliquity - obliquity).max() < 0.05 * arcsec


@pytest.mark.parametrize("lines", SETS, ids=["hypso", "vanguard", "molniya", "geostationary"])
def test_a_sampled_orbit_is_that_of_the_theory(lines):
    """To a centimetre, at any time and in any shape, and no number outside its span."""
    own = element_set(lines)
    states = own.over(own.epoch, 0.0, 86400.0)
    table = sampled(states, 0.0, 86400.0)
    times = np.random.default_rng(13).uniform(0.0, 86400.0, (25, 20))
    found = at(table, times)
    r, v = states(times.ravel())
    assert np.linalg.norm(found.position.reshape(-1, 3) - r, axis=1).max() < TOLERANCE
    np.testing.assert_allclose(found.velocity.reshape(-1, 3), v, atol=1e-4)
    ends = at(table, np.array([0.0, 86400.0, -1.0, 86401.0]))
    assert np.isfinite(ends.position[:2]).all() and np.isnan(ends.position[2:]).all()
    assert at(table, np.asarray(times[0, 0])).position.shape == (3,)


def test_another_orbit_over_the_same_time_is_not_compiled_anew(compilations):
    own = element_set(HYPSO1)
    follow = jax.jit(lambda ephemeris, times: ephemeris.at(times).position)
    times = np.linspace(0.0, 70.0, 7)
    for days in (0.0, 0.02, 1.3):
        states = own.over(own.epoch + days, 0.0, 70.0)
        seen = len(compilations)
        found = follow(sampled(states, -600.0, 670.0), times)
        assert np.linalg.norm(found - states(times)[0], axis=1).max() < TOLERANCE
        assert days == 0.0 or len(compilations) == seen
    assert compilations


def test_old_elements_are_warned_about_by_how_much_they_may_be_off():
    own = element_set(HYPSO1, "HYPSO-1")
    ages = np.array([0.0, 3.0, 10.0, 30.0])
    off = np.array([own.off_by(own.epoch + age) for age in ages])
    assert (np.diff(off) > 0.0).all() and off[0] == pytest.approx(1e3, rel=1e-6)
    assert off[-1] > 1e5
    assert own.warning(own.epoch - 3.0) == ""
    late, early = own.warning(own.epoch + 10.0), own.warning(own.epoch - 10.0)
    assert "10.0 days old" in late and f"about {1e-3 * off[2]:.0f} km" in late
    assert "10.0 days ahead" in early


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a, b: (f"{a[:68]}7", b), "checksum of line 1, its last character, is 7 where 9"),
        (lambda a, b: (a, f"{b[:20]}9{b[21:]}"), "checksum of line 2"),
        (lambda a, b: (a[:60], b), "has 60 characters"),
        (lambda a, b: (b, a), "give line 1, then line 2"),
        (lambda a, b: (a, checksummed(f"2 51054{b[7:]}")), "different satellites"),
        (lambda a, b: (checksummed(f"{a[:18]} 25.25094534449{a[33:]}"[:69]), b), "columns"),
    ],
)
def test_lines_that_were_changed_are_refused(change, said):
    with pytest.raises(OrbitDataError, match=said) as caught:
        element_set(change(*HYPSO1))
    assert "; " in str(caught.value)


def test_a_text_of_several_sets():
    text = "\n".join(["HYPSO-1   ", *HYPSO1, "0 VANGUARD 1", *REPORT[0], *REPORT[1]])
    sets = read_tle(text)
    assert [s.name for s in sets] == ["HYPSO-1", "VANGUARD 1", ""]
    assert [s.number for s in sets] == ["51053", "00005", "08195"]
    assert choose(sets, "vanguard 1", None) is sets[1] and choose(sets, "08195", None) is sets[2]
    # A line that was changed does not matter where another object is asked for.
    changed = text.replace("  .00000023", "  .00000024")
    assert [s.name for s in read_tle(changed, "hypso-1")] == ["HYPSO-1"]
    with pytest.raises(OrbitDataError, match="checksum"):
        read_tle(changed, "00005")
    for wanted, said in (("", "several satellites"), ("ISS", 'no object "ISS"')):
        with pytest.raises(OrbitDataError, match=said):
            choose(sets, wanted, None)
    for alone in (HYPSO1[0], "\n".join(HYPSO1[::-1])):
        assert kind_of(alone) == "tle"
        with pytest.raises(OrbitDataError, match="no second line"):
            read_tle(alone)
    for nothing in ("", "a text"):
        with pytest.raises(OrbitDataError, match="give both lines"):
            read_tle(nothing)


def test_of_several_sets_of_one_satellite_the_nearest_is_taken():
    own = element_set(HYPSO1)
    other = element_set(
        tuple(checksummed(line) for line in (HYPSO1[0].replace("25250", "25255"), HYPSO1[1]))
    )
    assert other.epoch == pytest.approx(own.epoch + 5.0)
    assert choose([own, other], "", None) is other
    assert choose([own, other], "", own.epoch + 1.0) is own


def test_an_orbit_that_has_decayed_is_refused():
    own = element_set(HYPSO1)
    with pytest.raises(OrbitDataError, match=r"days old at the start: .*Earth's radius; take"):
        ElementSet(own.name, own.number, own.satrec).over(own.epoch + 2000.0, 0.0, 60.0)
