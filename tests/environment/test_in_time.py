"""The environment as a function of time, against direct evaluation, ppigrf and differences."""

import datetime as dt

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.environment import epoch, frames, igrf, in_time, kepler, orbit
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.eclipse_times import eclipses
from jaxatt.environment.interpolant import interpolate
from jaxatt.environment.light import Light, sunlight
from jaxatt.environment.motion import TwoBody
from jaxatt.environment.precession import earth_fixed

EPOCH = dt.datetime(2022, 4, 1, tzinfo=dt.UTC)
MU = 3.986e14
DEGREES = (97.427, 215.365, 83.564, 34.004)
LAST = 6000.0
LIGHT = Light(1361.0, shadow=Shadow())


@pytest.fixture(scope="module")
def task():
    """The orbit of Kristiansen (2023), table 6.1."""
    elements = kepler.KeplerianElements(
        *(jnp.asarray(v) for v in (6898e3, 0.000713, *np.deg2rad(DEGREES)))
    )
    days = epoch.days_since_j2000(EPOCH)
    return OrbitTask(TwoBody(elements, MU), days, igrf.at_year(epoch.decimal_year(EPOCH)))


@pytest.fixture(scope="module")
def environment(task):
    return in_time.in_time(task, LIGHT, 0.0, LAST)


def times(count=200):
    return np.sort(np.random.default_rng(3).uniform(0.0, LAST, count))


@jax.jit
def at(environment, moments):
    return jax.vmap(environment.at)(jnp.asarray(moments))


def test_position_frame_and_sun_are_those_of_the_orbit(task, environment):
    moments = times()
    found = at(environment, moments)
    r, v = orbit.propagate(*kepler.to_state(task.motion.elements, MU), jnp.asarray(moments), MU)
    np.testing.assert_allclose(found.position.array, r, rtol=0.0, atol=7e-3)
    expected = np.asarray(frames.quaternion_io(r, v))
    q = np.asarray(found.q_io.array)
    assert np.abs(np.sum(q * expected, axis=1)).min() > 1.0 - 1e-12
    assert np.sum(q[1:] * q[:-1], axis=1).min() > 0.0
    turning = np.einsum("tij,tj->ti", frames.matrix_io(r, v), frames.omega_io(r, v))
    np.testing.assert_allclose(found.orbit_rate.array, turning, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found.gradient, 3.0 * MU / np.linalg.norm(r, axis=1) ** 3, rtol=1e-9)
    direction, _ = sunlight(LIGHT, r, jnp.asarray(task.days + moments / 86400.0))
    np.testing.assert_allclose(found.sun.array, direction, rtol=0.0, atol=1e-10)


def test_field_is_that_of_ppigrf(task, environment):
    ppigrf = pytest.importorskip("ppigrf")
    moments = times(40)
    found = at(environment, moments)
    turn = np.asarray(earth_fixed(jnp.asarray(task.days + moments / 86400.0)))
    x, y, z = np.einsum("tij,tj->it", turn, np.asarray(found.position.array))
    radius = np.sqrt(x**2 + y**2 + z**2)
    theta, phi = np.arccos(z / radius), np.arctan2(y, x)
    parts = ppigrf.igrf_gc(
        radius / 1e3, np.rad2deg(theta), np.rad2deg(phi), EPOCH.replace(tzinfo=None)
    )
    axes = (
        np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1),
        np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)], 1),
        np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], 1),
    )
    fixed = sum(np.ravel(p)[:, None] * a for p, a in zip(parts, axes, strict=True))
    expected = np.einsum("tji,tj->ti", turn, fixed)
    np.testing.assert_allclose(1e9 * np.asarray(found.field.array), expected, atol=1.0)


def test_shadow_is_that_of_the_orbit(task, environment):
    passage = eclipses(task, LIGHT, 0.0, LAST)[0]
    edges = [passage.penumbra_entry, passage.umbra_entry, passage.umbra_exit, passage.penumbra_exit]
    seen = at(environment, edges).disks
    np.testing.assert_allclose(np.asarray(seen.into_penumbra)[[0, 3]], 0.0, atol=1e-8)
    np.testing.assert_allclose(np.asarray(seen.into_umbra)[[1, 2]], 0.0, atol=1e-8)
    # Near what the source's figures 6.4 and 6.5 show.
    np.testing.assert_allclose(edges, [2800.0, 2800.0, 4850.0, 4850.0], atol=25.0)


@pytest.mark.parametrize("name", ["lit", "moving"])
def test_derivatives_in_time_are_those_of_the_values(environment, name):
    table, moments = getattr(environment, name), jnp.asarray(times(50))
    value, slope, bend = jax.jit(jax.vmap(table.to_second_order))(moments)
    h = 2.0
    ahead, behind = (at(table, moments + s * h) for s in (1.0, -1.0))
    size = np.abs(np.asarray(value)).max(axis=0, keepdims=True)
    rate = 1.2e-3
    central = np.asarray(ahead - behind) / (2.0 * h)
    assert (np.abs(np.asarray(slope) - central) / size).max() < 1e-4 * rate
    second = np.asarray(ahead - 2.0 * value + behind) / h**2
    assert (np.abs(np.asarray(bend) - second) / size).max() < 1e-2 * rate**2
    differentiated = jax.jit(jax.vmap(jax.jacfwd(table.at)))(moments)
    np.testing.assert_allclose(differentiated / size, slope / size, atol=1e-13)
    again = jax.jit(jax.vmap(jax.jacfwd(jax.jacfwd(table.at))))(moments)
    np.testing.assert_allclose(again / size, bend / size, atol=1e-13)


def test_an_interpolant_is_twice_continuous_and_of_sixth_order():
    def values(t):
        return np.stack([np.sin(t), np.exp(-t)], axis=1)

    moments = np.linspace(0.0, 3.0, 301)
    errors = []
    for step in (0.2, 0.1):
        table = interpolate(values, 0.0, 3.0, step)
        found = np.asarray(at(table, moments))
        errors.append(np.abs(found - values(moments)).max())
        node = 5 * step
        sides = [table.to_second_order(jnp.asarray(node + side)) for side in (-1e-9, 1e-9)]
        for left, right in zip(*sides, strict=True):
            np.testing.assert_allclose(left, right, atol=1e-6)
    assert errors[0] < 1e-8
    assert errors[0] / errors[1] > 40.0
