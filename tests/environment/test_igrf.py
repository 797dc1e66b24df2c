"""IGRF-14 against the package ppigrf, along a day of an orbit and anywhere else."""

import datetime as dt

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.environment import epoch, igrf, kepler, orbit
from jaxatt.environment.along_orbit import OrbitTask, evaluate
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.motion import TwoBody
from jaxatt.environment.precession import earth_fixed

field = jax.jit(igrf.field)


def from_ppigrf(position, moment):
    """Field (n, 3) [nT] in Earth-fixed axes at one moment."""
    ppigrf = pytest.importorskip("ppigrf")
    radius = np.linalg.norm(position, axis=1)
    theta = np.arccos(position[:, 2] / radius)
    phi = np.arctan2(position[:, 1], position[:, 0])
    naive = moment.replace(tzinfo=None)
    parts = ppigrf.igrf_gc(radius / 1e3, np.rad2deg(theta), np.rad2deg(phi), naive)
    up, south, east = (np.ravel(part) for part in parts)
    axis_r = position / radius[:, None]
    axis_t = np.stack(
        [np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)], axis=1
    )
    axis_p = np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], axis=1)
    return up[:, None] * axis_r + south[:, None] * axis_t + east[:, None] * axis_p


def model(moment):
    return igrf.at_year(epoch.decimal_year(moment))


@pytest.mark.parametrize("year", [1935, 1999, 2014, 2020, 2026])
def test_field_agrees_with_ppigrf(year):
    rng = np.random.default_rng(year)
    moment = dt.datetime(year, int(rng.integers(1, 13)), 11, 7, tzinfo=dt.UTC)
    position = rng.normal(size=(200, 3))
    position *= rng.uniform(6.4e6, 9e6, (200, 1)) / np.linalg.norm(position, axis=1)[:, None]
    found = 1e9 * np.asarray(field(model(moment), position))
    expected = from_ppigrf(position, moment)
    assert np.abs(expected).max() > 1e4
    np.testing.assert_allclose(found, expected, atol=1.0)


def test_field_agrees_with_ppigrf_over_a_day_of_orbit():
    moment = dt.datetime(2020, 3, 20, 12, tzinfo=dt.UTC)
    elements = kepler.KeplerianElements(
        *(jnp.asarray(v) for v in (6852.2e3, 0.002, 1.693, 4.887, 0.0, 1.571))
    )
    times = jnp.arange(0.0, 86400.0, 60.0)
    days = epoch.days_since_j2000(moment)
    task = OrbitTask(TwoBody(elements, 3.986e14), days, model(moment))
    along, nodes = jax.jit(evaluate, static_argnames="tidal")(task, ExternalTorques(), False, times)
    inertial = 1e9 * np.asarray(along.field.array)
    turn = np.asarray(earth_fixed(days + times / 86400.0))
    r_i, _ = orbit.propagate(*kepler.to_state(elements, 3.986e14), times, 3.986e14)
    fixed = np.einsum("kij,kj->ki", turn, np.asarray(r_i))
    # One date for the whole day: the field changes by less than 0.3 nT in it.
    expected = np.einsum("kji,kj->ki", turn, from_ppigrf(fixed, moment))
    np.testing.assert_allclose(inertial, expected, atol=1.0)
    np.testing.assert_array_equal(nodes.field.array, along.field.array)


def test_poles_are_points_like_any_others():
    moment = dt.datetime(2020, 3, 20, 12, tzinfo=dt.UTC)
    near = np.array([[0.0, 0.0, 6.8e6], [1e-3, -1e-3, 6.8e6], [0.0, 0.0, -6.8e6]])
    found = np.asarray(field(model(moment), near))
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6)


def test_field_has_no_sources():
    moment = dt.datetime(2024, 1, 1, tzinfo=dt.UTC)
    at = np.array([5e6, -3e6, 4e6])
    slope = np.asarray(jax.jacfwd(lambda r: field(model(moment), r))(at))
    size = np.abs(slope).max()
    assert abs(np.trace(slope)) < 1e-10 * size
    np.testing.assert_allclose(slope, slope.T, atol=1e-10 * size)


@pytest.mark.parametrize("year", [1899.9, 2030.1])
def test_years_without_coefficients_are_refused(year):
    with pytest.raises(ValueError, match=r"epoch: .*1900 to 2030"):
        igrf.at_year(year)
