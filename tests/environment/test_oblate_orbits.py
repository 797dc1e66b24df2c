"""Orbits about an oblate Earth: integration, mean elements, and how the orbit frame turns."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.environment import KeplerianElements, frames, kepler
from jaxatt.environment.ephemeris import sampled
from jaxatt.environment.orbit import MU_EARTH, mean_motion
from jaxatt.environment.orbit_data.j2 import (
    J2,
    RADIUS,
    OblatePath,
    Propagation,
    acceleration,
    pole_of_date,
)
from jaxatt.environment.orbit_data.mean_elements import mean_elements, osculating_state

POLE = np.array([0.0, 0.0, 1.0])
to_state, from_state = jax.jit(kepler.to_state), jax.jit(kepler.from_state)


def elements(seed):
    rng = np.random.default_rng(seed)
    return KeplerianElements(
        rng.uniform(6.9e6, 8e6),
        rng.uniform(0.0, 0.05),
        *rng.uniform(0.2, 2.9, 1),
        *rng.uniform(0.0, 6.0, 3),
    )


def start(seed):
    return tuple(np.asarray(part) for part in to_state(elements(seed)))


def potential(r, pole):
    """Energy (n,) [J/kg] in the field of an oblate Earth, up to its sign."""
    radius = np.linalg.norm(r, axis=-1)
    sine = r @ pole / radius
    return MU_EARTH / radius * (1.0 - J2 * (RADIUS / radius) ** 2 * 0.5 * (3.0 * sine**2 - 1.0))


def test_acceleration_is_the_slope_of_the_potential():
    pole = np.array([0.6, 0.0, 0.8])
    r = np.random.default_rng(1).normal(size=(50, 3)) * 7e6
    step = 100.0 * np.eye(3)
    slope = [(potential(r + s, pole) - potential(r - s, pole)) / 200.0 for s in step]
    expected = np.stack(slope, axis=1)
    np.testing.assert_allclose(acceleration(r, pole), expected, rtol=0.0, atol=1e-7)
    assert np.abs(expected + MU_EARTH * r / np.linalg.norm(r, axis=1)[:, None] ** 3).max() > 1e-3


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_energy_and_momentum_about_the_axis_stay(seed):
    pole = pole_of_date(9600.0)
    assert 0.1 < np.degrees(np.arccos(pole @ POLE)) < 0.2
    r0, v0 = start(seed)
    times = np.random.default_rng(seed).uniform(-6000.0, 20000.0, 50)
    motion = Propagation(r0, v0, pole)
    r, v = motion(times)
    energy = 0.5 * np.square(v).sum(axis=1) - potential(r, pole)
    np.testing.assert_allclose(energy, 0.5 * v0 @ v0 - potential(r0, pole), rtol=1e-10)
    np.testing.assert_allclose(np.cross(r, v) @ pole, np.cross(r0, v0) @ pole, rtol=1e-10)
    ahead, behind = (motion(times + later) for later in (0.05, -0.05))
    np.testing.assert_allclose((ahead[0] - behind[0]) / 0.1, v, rtol=0.0, atol=1e-3)
    np.testing.assert_allclose((ahead[1] - behind[1]) / 0.1, acceleration(r, pole), atol=1e-5)
    again = OblatePath(r0, v0, 9600.0, pole, MU_EARTH).over(9600.0 + 0.1, 0.0, 60.0)
    np.testing.assert_allclose(again(times - 8640.0)[0], r, rtol=0.0, atol=1e-3)


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_mean_elements_come_back_and_the_node_drifts_by_them(seed):
    """By -3/2 n J2 (R/p)^2 cos i; the osculating semi-major axis swings, the mean one does not."""
    given = elements(seed)
    r, v = osculating_state(given, POLE, MU_EARTH)
    back = mean_elements(r, v, POLE, MU_EARTH)
    r_too, v_too = to_state(back)
    r_given, v_given = to_state(given)
    np.testing.assert_allclose(r_too, r_given, rtol=0.0, atol=1e-3)
    np.testing.assert_allclose(v_too, v_given, rtol=0.0, atol=1e-6)
    a, n = float(given.semi_major_axis), float(mean_motion(given.semi_major_axis))
    own = from_state(r, v)
    assert abs(float(own.semi_major_axis) - a) > 10.0
    motion, turns = Propagation(r, v, POLE), 8
    span = turns * 2.0 * np.pi / n
    later = mean_elements(*(part[0] for part in motion(np.array([span]))), POLE, MU_EARTH)
    p = a * (1.0 - float(given.eccentricity) ** 2)
    expected = -1.5 * n * J2 * (RADIUS / p) ** 2 * np.cos(float(given.inclination)) * span
    drift = float(later.raan - given.raan)
    drift = (drift + np.pi) % (2.0 * np.pi) - np.pi
    assert drift == pytest.approx(expected, rel=5e-3, abs=1e-6)
    assert float(later.semi_major_axis) == pytest.approx(a, abs=30.0)
    swing = from_state(*motion(np.linspace(0.0, 2.0 * np.pi / n, 60))).semi_major_axis
    assert np.ptp(swing) > 2e3 * np.sin(float(given.inclination)) ** 2


def test_the_rate_of_the_orbit_frame_has_the_turning_of_the_plane():
    """dR_io/dt = R_io S(omega_io) along a sampled orbit, whose plane J2 turns."""
    motion = Propagation(*start(6), POLE)
    table = sampled(motion, 0.0, 6000.0)
    times = np.random.default_rng(6).uniform(100.0, 5900.0, 40)

    @jax.jit
    def at(times):
        here = table.at(times)
        return frames.matrix_io(here.position, here.velocity), frames.omega_io(*here)

    (ahead, _), (behind, _), (here, omega) = at(times + 0.5), at(times - 0.5), at(times)
    spun = np.einsum("tji,tjk->tik", here, np.asarray(ahead - behind))
    found = np.stack([spun[:, 2, 1], spun[:, 0, 2], spun[:, 1, 0]], axis=1)
    np.testing.assert_allclose(omega, found, rtol=0.0, atol=2e-10)
    assert np.abs(omega[:, 2]).max() > 1e-7
    flat = frames.omega_io(*map(jnp.asarray, motion(times)))
    np.testing.assert_allclose(omega[:, 1], flat[:, 1], rtol=1e-8)
    assert not np.asarray(flat[:, 2]).any()
