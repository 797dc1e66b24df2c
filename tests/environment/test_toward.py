"""Directions from a satellite: rates beside differences, a place on the ground beside astropy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from references.astropy_sight import astropy_sight
from scipy.spatial.transform import Rotation

from jaxatt.environment import epoch, ground, igrf, toward
from jaxatt.environment.kepler import KeplerianElements
from jaxatt.environment.motion import TwoBody
from jaxatt.environment.orbit import MU_EARTH

DAYS = epoch.days_since_j2000(epoch.parse("2026-04-03T10:20:30Z"))
SITE = (np.deg2rad(63.42), np.deg2rad(10.39), 120.0)


def orbit(raan=0.3, anomaly=1.0):
    angles = (0.002, np.deg2rad(97.5), raan, 0.4, anomaly)
    return TwoBody(KeplerianElements(jnp.asarray(6.9e6), *map(jnp.asarray, angles)), MU_EARTH)


MOTION = orbit()
ALL = {
    "stars": toward.AmongStars(np.array([1.0, -2.0, 0.5])),
    "nadir": toward.InOrbitAxes(np.array([0.0, 0.0, 1.0]), MOTION),
    "velocity": toward.AlongVelocity(MOTION),
    "sun": toward.ToSun(DAYS),
    "field": toward.AlongField(MOTION, DAYS, igrf.at_year(2026.25)),
    "site": toward.ToSite(MOTION, DAYS, *SITE),
    "satellite": toward.ToSatellite(MOTION, orbit(0.31, 1.1)),
}
TWO = [("site", "velocity"), ("sun", "nadir"), ("field", "satellite"), ("nadir", "stars")]


def rotation(q):
    return Rotation.from_quat(np.asarray(q), scalar_first=True)


@pytest.mark.parametrize(("first", "second"), TWO)
def test_the_rate_is_the_one_that_follows_the_directions(first, second):
    rng = np.random.default_rng(2911)
    body, second_body = rng.normal(size=(2, 3))
    time, half = float(rng.uniform(0.0, 3000.0)), 0.05
    at = jax.jit(lambda t: toward.pose(body, ALL[first], second_body, ALL[second], t))
    _, rate = at(jnp.asarray(time))
    ahead, behind = (rotation(at(jnp.asarray(time + side))[0]) for side in (half, -half))
    turned = (behind.inv() * ahead).as_rotvec() / (2.0 * half)
    np.testing.assert_allclose(rate, turned, atol=1e-9)
    assert np.linalg.norm(turned) > 1e-9 or (first, second) == ("sun", "stars")


def test_nadir_and_velocity_are_those_of_the_orbit():
    for time in np.random.default_rng(2911).uniform(0.0, 6000.0, 5):
        here = MOTION.at(jnp.asarray(time))
        down, along = (ALL[name].at(jnp.asarray(time)) for name in ("nadir", "velocity"))
        np.testing.assert_allclose(
            down, -here.position / jnp.linalg.norm(here.position), atol=1e-14
        )
        np.testing.assert_array_equal(along, here.velocity)
        assert float(toward.apart(ALL["nadir"], ALL["velocity"], jnp.asarray(time))) == (
            pytest.approx(np.pi / 2, abs=0.01)
        )


def closest(site):
    """Time [s] at which the satellite stands highest over a place."""
    times = jnp.linspace(0.0, 86400.0, 86401)
    heights = jax.jit(jax.vmap(site.elevation))(times)
    return float(times[int(jnp.argmax(heights))]), float(jnp.max(heights))


def test_a_place_at_the_closest_approach_beside_astropy():
    pytest.importorskip("astropy")
    site = ALL["site"]
    time, height = closest(site)
    assert height > np.deg2rad(20.0)
    body, second_body = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    q, rate = toward.pose(body, site, second_body, ALL["velocity"], jnp.asarray(time))
    known = {
        side: astropy_sight(DAYS, time + side, MOTION.at(jnp.asarray(time + side)).position, SITE)
        for side in (-0.5, 0.0, 0.5)
    }
    boresight = rotation(q).apply(body)
    off = np.arctan2(np.linalg.norm(np.cross(boresight, known[0.0])), boresight @ known[0.0])
    assert np.rad2deg(off) < 0.01
    # What turns the boresight; about the boresight the velocity decides.
    swept = np.cross(known[0.0], (known[0.5] - known[-0.5]))
    across = rotation(q).apply(np.array(rate))
    across = across - boresight * (boresight @ across)
    np.testing.assert_allclose(across, swept, atol=1e-6)
    assert np.linalg.norm(across) > 5e-3


def test_the_field_is_that_of_the_model():
    time = jnp.asarray(1234.5)
    turn = np.asarray(ground.earth_fixed(np.eye(3), DAYS + 1234.5 / epoch.SECONDS_PER_DAY)).T
    there = turn @ np.asarray(MOTION.at(time).position)
    known = turn.T @ np.asarray(igrf.field(igrf.at_year(2026.25), there))
    np.testing.assert_allclose(ALL["field"].at(time), known, rtol=1e-9)
