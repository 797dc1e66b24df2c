"""Shadow against its algorithm as printed, rays to the sun's disk, and an integrated orbit."""

import datetime as dt
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from jaxatt.environment import epoch, kepler, sun
from jaxatt.environment.along_orbit import OrbitTask, evaluate, tabulate
from jaxatt.environment.eclipse import Shadow, lit_share
from jaxatt.environment.eclipse_times import eclipses
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.light import Light, sunlight
from jaxatt.environment.motion import TwoBody

MU = 3.986e14
SHADOW = Shadow()
# Kristiansen (2023), table 6.1.
ELEMENTS = kepler.KeplerianElements(
    *(jnp.asarray(v) for v in (6898e3, 0.000713, *np.deg2rad([97.427, 215.365, 83.564, 34.004])))
)
TASK = OrbitTask(
    TwoBody(ELEMENTS, jnp.asarray(MU)),
    jnp.asarray(epoch.days_since_j2000(dt.datetime(2022, 4, 1, tzinfo=dt.UTC))),
)
share = jax.jit(lit_share)


def as_printed(r_i, to_sun, shadow=SHADOW):
    """Kristiansen (2023), algorithm 1, line by line: share, and conditions 2 and 3 [rad]."""
    r_sun, r_earth = to_sun, -r_i
    re, rs = shadow.earth_radius, shadow.sun_radius
    es = r_sun - r_earth
    cap_int, cap_ext = re / (re + rs) * es, re / (re - rs) * es
    pos = r_earth @ (es / np.linalg.norm(es))
    inside = []
    for cap in (cap_int, cap_ext):
        cone = np.arcsin(re / np.linalg.norm(cap))
        adjacent = (r_earth @ cap) / (cap @ cap) * cap
        hypotenuse = cap + r_earth
        sine = np.linalg.norm(np.cross(hypotenuse, adjacent))
        sine /= np.linalg.norm(hypotenuse) * np.linalg.norm(adjacent)
        inside.append(cone - np.arcsin(np.minimum(sine, 1.0)))
    if pos <= 0.0 or inside[0] <= 0.0:
        return 1.0, inside
    return (0.0 if inside[1] > 0.0 else shadow.penumbra), inside


def places(count, seed):
    """Positions (count, 3) [m] near the edges of the shadow, and vectors to the sun."""
    rng = np.random.default_rng(seed)
    toward = rng.normal(size=(count, 3))
    toward /= np.linalg.norm(toward, axis=1)[:, None]
    across = np.cross(toward, rng.normal(size=(count, 3)))
    across /= np.linalg.norm(across, axis=1)[:, None]
    radius = rng.uniform(6.5e6, 4.3e7, count)
    edge = np.pi - np.arcsin(SHADOW.earth_radius / radius)
    angle = edge + rng.uniform(-0.01, 0.01, count)
    r_i = (np.cos(angle) * toward.T + np.sin(angle) * across.T).T * radius[:, None]
    return r_i, 1.495e11 * toward - r_i


def test_share_is_that_of_the_printed_algorithm():
    r_i, to_sun = places(3000, 1)
    found = np.asarray(share(SHADOW, r_i, to_sun))
    expected = np.array([as_printed(r, s)[0] for r, s in zip(r_i, to_sun, strict=True)])
    assert all(np.sum(expected == value) > 100 for value in (0.0, 0.2, 1.0))
    np.testing.assert_array_equal(found, expected)


def test_there_is_light_all_over_the_day_side():
    rng = np.random.default_rng(2)
    r_i = rng.normal(size=(1000, 3)) * 5e6
    r_i *= 7e6 / np.linalg.norm(r_i, axis=1)[:, None]
    toward = np.broadcast_to([0.0, 0.6, 0.8], r_i.shape)
    day = r_i @ toward[0] > 0.0
    assert day.sum() > 300
    np.testing.assert_array_equal(share(SHADOW, r_i, 1.5e11 * toward - r_i)[day], 1.0)


def test_disk_share_by_rays():
    r_i, to_sun = places(200, 3)
    shadow = Shadow(None)
    found = np.asarray(share(shadow, r_i, to_sun))
    rng = np.random.default_rng(4)
    angle, level = rng.uniform(0.0, 2.0 * np.pi, 20000), np.sqrt(rng.uniform(size=20000))
    for r, s, one in zip(r_i, to_sun, found, strict=True):
        axis = s / np.linalg.norm(s)
        side = np.cross(axis, [0.3, -0.2, 0.9])
        side /= np.linalg.norm(side)
        limb = level * np.arcsin(shadow.sun_radius / np.linalg.norm(s))
        ring = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * np.cross(axis, side)
        ray = np.cos(limb)[:, None] * axis + np.sin(limb)[:, None] * ring
        along = ray @ -r
        past = np.sqrt(np.maximum(r @ r - along**2, 0.0))
        seen = 1.0 - np.mean((along > 0.0) & (past < shadow.earth_radius))
        assert one == pytest.approx(seen, abs=0.015)
    assert np.sum((found > 0.0) & (found < 1.0)) > 50


@pytest.mark.parametrize("penumbra", [0.2, None])
def test_gradual_edges_tend_to_sharp_ones(penumbra):
    shadow = Shadow(penumbra)
    r_i, to_sun = places(2000, 5)
    exact = np.asarray(share(shadow, r_i, to_sun))
    errors = []
    for width in (1e-2, 1e-3, 1e-5):
        gradual = np.asarray(share(shadow, r_i, to_sun, width))
        assert gradual.min() >= 0.0 and gradual.max() <= 1.0
        errors.append(np.mean(np.abs(gradual - exact)))
    assert errors[0] > errors[1] >= errors[2]
    # With the real disk the penumbra keeps its width, and a smooth rise stands for its share.
    assert errors[2] < (1e-3 if penumbra is not None else 0.01)
    assert np.abs(gradual - exact).max() < (1.0 if penumbra is not None else 0.021)


@pytest.mark.parametrize("penumbra", [0.2, None])
def test_gradient_of_gradual_edges(penumbra):
    shadow, width, step = Shadow(penumbra), 0.02, 1.0
    r_i, to_sun = places(200, 6)
    toward = np.random.default_rng(7).normal(size=r_i.shape)
    toward /= np.linalg.norm(toward, axis=1)[:, None]

    def along(distance):
        moved = r_i + distance * toward
        return lit_share(shadow, moved, to_sun, width)

    zero = jnp.asarray(0.0)
    _, slope = jax.jvp(along, (zero,), (zero + 1.0,))
    difference = (along(zero + step) - along(zero - step)) / (2.0 * step)
    assert np.abs(slope).max() > 1e-6
    np.testing.assert_allclose(slope, difference, atol=1e-11)


def test_gradients_are_finite_on_the_axis_and_at_the_edge():
    on_axis = jnp.asarray([-7e6, 0.0, 0.0])
    for penumbra in (0.2, None):
        slope = jax.grad(lambda r, p=penumbra: lit_share(Shadow(p), r, 1.5e11 - r, 0.01).sum())
        assert np.isfinite(slope(on_axis)).all()
        slope = jax.grad(lambda r, p=penumbra: lit_share(Shadow(p), r, 1.5e11 - r))
        assert np.isfinite(slope(on_axis)).all()


def test_times_in_the_shadow_by_an_integrated_orbit():
    """Chapter 6 starts at this epoch and has its eclipse from about 2800 to about 4800 s."""
    light = Light(1361.0, None, SHADOW)
    (found,) = eclipses(TASK, light, 0.0, 6000.0)
    r_i, v_i = kepler.to_state(ELEMENTS, MU)

    def motion(_, y):
        return np.concatenate([y[3:], -MU * y[:3] / np.linalg.norm(y[:3]) ** 3])

    start = np.concatenate([r_i, v_i])
    path = solve_ivp(motion, (0.0, 6000.0), start, rtol=1e-11, atol=1e-6, dense_output=True).sol

    def depth(time, row):
        at = path(time)[:3]
        day = TASK.days + time / 86400.0
        return as_printed(at, np.asarray(sun.sun_position(jnp.asarray(day))) - at)[1][row]

    brackets = {
        "penumbra_entry": (2700.0, 2900.0, 0),
        "umbra_entry": (2700.0, 2900.0, 1),
        "umbra_exit": (4700.0, 4900.0, 1),
        "penumbra_exit": (4700.0, 4900.0, 0),
    }
    for name, (low, high, row) in brackets.items():
        expected = brentq(depth, low, high, args=(row,), xtol=1e-6)
        assert getattr(found, name) == pytest.approx(expected, abs=1e-3)
    # 2787 and 4853 s with a sun of the equinox of the date, 0.31 deg further on.
    assert found.penumbra_entry == pytest.approx(2790.5, abs=0.2)
    assert found.penumbra_exit == pytest.approx(4854.0, abs=0.2)


def test_seconds_in_the_penumbra_of_chapter_5():
    """Section 5.8 prints about 20 s, entry and exit together, of the orbit of table 5.4."""
    degrees = np.deg2rad([97.439, 139.3136, 33.7547, 54.0])
    elements = kepler.KeplerianElements(*(jnp.asarray(v) for v in (6905.1e3, 0.0007757, *degrees)))
    fixed_sun = 1.4959987e11 * np.array([0.8944, 0.0, 0.4472])
    task = OrbitTask(TwoBody(elements, jnp.asarray(MU)), jnp.asarray(0.0))
    (found,) = eclipses(task, Light(1361.0, fixed_sun, SHADOW), 0.0, 5580.0)
    both = found.umbra_entry - found.penumbra_entry + found.penumbra_exit - found.umbra_exit
    assert both == pytest.approx(20.0, abs=1.0)


def test_events_outside_the_interval_are_no_numbers():
    light = Light(1361.0, None, SHADOW)
    (begun,) = eclipses(TASK, light, 4000.0, 5000.0)
    assert math.isnan(begun.penumbra_entry) and math.isnan(begun.umbra_entry)
    assert begun.umbra_exit < begun.penumbra_exit
    (between,) = eclipses(TASK, light, 2795.0, 2799.0)
    assert all(math.isnan(value) for value in vars(between).values())
    (first, second) = eclipses(TASK, light, 2795.0, 8495.0)
    assert math.isnan(first.penumbra_entry) and math.isnan(second.penumbra_exit)
    assert 2795.0 < first.umbra_entry < first.umbra_exit < first.penumbra_exit < 8400.0
    assert math.isnan(second.umbra_entry) and second.penumbra_entry > 8400.0
    assert eclipses(TASK, light, 0.0, 2700.0) == ()
    assert eclipses(TASK, Light(1361.0), 0.0, 6000.0) == ()


def test_table_along_the_orbit_has_sun_and_light():
    light = Light(1361.0, None, SHADOW)
    along, _ = tabulate(TASK, ExternalTorques(), False, 1.0, 100, start=2750.0, light=light)
    assert along.sun is not None and along.light is not None
    lit = np.asarray(along.light)[:, 0]
    assert set(np.unique(lit)) == {0.0, 0.2, 1.0}
    times = 2750.0 + np.arange(100.0)
    assert times[np.argmax(lit < 1.0)] == 2791.0
    assert times[np.argmax(lit == 0.0)] == 2801.0
    expected = sun.sun_direction(TASK.days + times / 86400.0)
    # The satellite's own place turns it by less than 10 arcsec.
    np.testing.assert_allclose(along.sun.array[:, 0], expected, atol=5e-5)
    # Without a table of light the rest is as before.
    dark, _ = evaluate(TASK, ExternalTorques(), False, jnp.asarray(times))
    assert dark.sun is None and dark.light is None


def test_fixed_sun_by_place_or_by_direction():
    r_i = np.random.default_rng(8).normal(size=(5, 3)) * 4e6
    direction = np.array([0.8944, 0.0, 0.4472])
    near, _ = sunlight(Light(1361.0, 1.4959987e11 * direction), r_i, 0.0)
    far, lit = sunlight(Light(1361.0, direction), r_i, 0.0)
    np.testing.assert_allclose(near, far, atol=1e-7)
    np.testing.assert_array_equal(lit, 1.0)
    expected = 1.4959987e11 * direction - r_i
    expected /= np.linalg.norm(expected, axis=1)[:, None]
    np.testing.assert_allclose(near, expected, atol=1e-15)
