"""Sun and Earth-fixed axes against astropy, in one inertial frame."""

import datetime as dt
import warnings

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.environment import epoch, sun
from jaxatt.environment.precession import earth_fixed, precession

DATES = [
    dt.datetime(1990, 1, 1, tzinfo=dt.UTC) + dt.timedelta(days=float(days))
    for days in np.random.default_rng(1608).uniform(0.0, 45 * 365.25, 400)
]
DAYS = jnp.asarray([epoch.days_since_j2000(date) for date in DATES])


@pytest.fixture(scope="module")
def published():
    """Position of the sun (n, 3) [m], axes of the rotating Earth (n, 3, 3), both in GCRS, and UT1.

    UT1 : (n,) [days], since J2000.
    """
    pytest.importorskip("astropy")
    # Dates to come have no measured rotation; the warnings and the downloads are about that.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from astropy import units
        from astropy.coordinates import GCRS, ITRS, CartesianRepresentation, get_sun
        from astropy.time import Time
        from astropy.utils.iers import conf

        settings = {"auto_download": False, "auto_max_age": None}
        settings["iers_degraded_accuracy"] = "ignore"
        kept = {name: getattr(conf, name) for name in settings}
        for name, value in settings.items():
            setattr(conf, name, value)
        try:
            time = Time([date.replace(tzinfo=None) for date in DATES], scale="utc")
            position = get_sun(time).cartesian.xyz.to_value(units.m).T
            axes = []
            for axis in np.eye(3):
                parts = (np.full(len(DATES), part) * 7e6 * units.m for part in axis)
                here = ITRS(CartesianRepresentation(*parts), obstime=time)
                there = here.transform_to(GCRS(obstime=time))
                axes.append(there.cartesian.xyz.to_value(units.m).T / 7e6)
            ut1 = DAYS + np.asarray(time.delta_ut1_utc) / epoch.SECONDS_PER_DAY
        finally:
            for name, value in kept.items():
                setattr(conf, name, value)
    return position, np.stack(axes, axis=1), ut1


def angle(a, b):
    """Angle [deg] between vectors."""
    across = np.linalg.norm(np.cross(a, b), axis=-1)
    return np.rad2deg(np.arctan2(across, np.sum(np.asarray(a) * np.asarray(b), axis=-1)))


def test_direction_and_distance_of_the_sun(published):
    expected, _, _ = published
    found = np.asarray(sun.sun_position(DAYS))
    assert angle(found, expected).max() < 0.001
    np.testing.assert_allclose(
        np.linalg.norm(found, axis=1), np.linalg.norm(expected, axis=1), rtol=2e-5
    )
    assert angle(sun.sun_direction(DAYS), found).max() < 1e-10


def test_axes_of_the_rotating_earth(published):
    _, expected, ut1 = published
    for days, allowed in ((ut1, 0.0003), (DAYS, 0.004)):
        found = np.asarray(earth_fixed(days))
        for row in range(3):
            assert angle(found[:, row], expected[:, row]).max() < allowed


def test_the_longitude_below_the_sun(published):
    """UT1 and UTC are up to 0.9 s apart, which is 0.0038 deg; without that it is far better."""
    position, axes, ut1 = published
    expected = np.einsum("nij,nj->ni", axes, position)
    for days, allowed in ((ut1, 0.001), (DAYS, 0.005)):
        found = np.einsum("nij,nj->ni", earth_fixed(days), sun.sun_direction(DAYS))
        longitude = [np.rad2deg(np.arctan2(v[:, 1], v[:, 0])) for v in (found, expected)]
        apart = (longitude[0] - longitude[1] + 180.0) % 360.0 - 180.0
        assert np.abs(apart).max() < allowed


def test_the_sun_at_one_moment_can_be_differentiated():
    """Alone, in a batch of any shape, and its derivative against a difference."""
    shaped, along = jax.jit(sun.sun_direction)(DAYS.reshape(4, 100)), sun.sun_direction(DAYS)
    np.testing.assert_allclose(shaped.reshape(-1, 3), along, atol=1e-15)
    slope = jax.jit(jax.jacfwd(sun.sun_direction))(DAYS[7])
    near = sun.sun_direction(DAYS[7] + 0.01 * jnp.linspace(-1.0, 1.0, 400))
    np.testing.assert_allclose(slope, (near[-1] - near[0]) / 0.02, atol=1e-8)


def test_rotations_are_proper_and_start_at_j2000():
    for turn in (precession(DAYS), earth_fixed(DAYS)):
        np.testing.assert_allclose(
            turn @ np.swapaxes(turn, -1, -2), np.broadcast_to(np.eye(3), turn.shape), atol=1e-14
        )
        np.testing.assert_allclose(np.linalg.det(turn), 1.0, atol=1e-14)
    np.testing.assert_allclose(precession(jnp.asarray(0.0)), np.eye(3), atol=1e-10)
