"""Collecting area of panels: by hand, by the printed formula, smooth and exact, its gradient."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.attitude.components import Vector
from jaxatt.scenarios import load_vehicle
from jaxatt.spacecraft import FieldError, collecting_area, solar_panels

FACES = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]).T
RNG = np.random.default_rng(15)
SUNS = RNG.normal(size=(400, 3))
SUNS /= np.linalg.norm(SUNS, axis=1)[:, None]


def as_printed(sun, normals, factors, shading=None):
    """Kristiansen (2023), eqs. (4.4) and (5.4), exact, for one sun."""
    cosines = normals.T @ sun
    terms = np.maximum(cosines, 0.0) * cosines * factors
    if shading is None:
        return terms.sum()
    others = terms.sum() - terms[shading]
    return (1.0 - max(cosines[shading], 0.0)) * others + terms[shading]


@pytest.mark.parametrize("shading", [None, 0, 2])
def test_area_is_that_of_the_printed_formula(shading):
    normals = RNG.normal(size=(3, 5))
    area, efficiency = RNG.uniform(0.01, 0.2, 5), RNG.uniform(0.1, 0.3, 5)
    panels = solar_panels(normals, area, efficiency, shading, "cosine-squared")
    unit = normals / np.linalg.norm(normals, axis=0)
    expected = [as_printed(sun, unit, efficiency * area, shading) for sun in SUNS]
    np.testing.assert_allclose(collecting_area(panels, SUNS), expected, atol=1e-15)


def test_printed_peak_of_chapter_4():
    """Figure 4.6 tops out just above 16 W: the largest faces (0.06 m^2) squarely in the sun."""
    panels = load_vehicle("hypso1-solar").panels
    power = 1361.0 * np.asarray(collecting_area(panels, SUNS))
    assert power.max() < 1361.0 * collecting_area(panels, np.array([0.0, -1.0, 0.0]))
    assert 1361.0 * collecting_area(panels, np.array([0.0, 1.0, 0.0])) == pytest.approx(16.332)


def test_deployed_panels_of_hypso2_leave_nothing_to_the_others():
    panels = load_vehicle("hypso2").panels
    assert 1361.0 * collecting_area(panels, np.array([0.0, 1.0, 0.0])) == pytest.approx(39.1968)
    # 45 deg between +x and +y: (1 - 1/sqrt2) 0.024/2 + 0.144/2.
    half = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    expected = 0.2 * ((1.0 - np.sqrt(0.5)) * 0.012 + 0.072)
    assert collecting_area(panels, half) == pytest.approx(expected, rel=1e-12)
    # From behind they shade nothing.
    away = np.array([0.6, -0.8, 0.0])
    expected = 0.2 * (0.36 * 0.024 + 0.64 * 0.048)
    assert collecting_area(panels, away) == pytest.approx(expected, rel=1e-12)


def test_cosine_law_of_a_box_is_its_shadow():
    """Projected area of a convex body, by points that fall on it."""
    size = np.array([0.1, 0.2, 0.3])
    area = np.array([0.06, 0.03, 0.02] * 2)
    panels = solar_panels(FACES, area, 1.0)
    sun = np.array([0.48, 0.6, 0.64])
    side = np.cross(sun, [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    edge = 0.4
    grid = (np.arange(800) + 0.5) / 800 * edge - 0.5 * edge
    u, v = np.meshgrid(grid, grid)
    rays = u[..., None] * side + v[..., None] * np.cross(sun, side)
    low = (-0.5 * size - rays) / sun
    high = (0.5 * size - rays) / sun
    hit = low.max(axis=-1) < high.min(axis=-1)
    shadow = hit.mean() * edge**2
    assert collecting_area(panels, sun) == pytest.approx(shadow, rel=3e-3)


@pytest.mark.parametrize("incidence", ["cosine", "cosine-squared"])
@pytest.mark.parametrize("shading", [None, 1])
def test_components_arrays_and_batches_agree(incidence, shading):
    panels = solar_panels(FACES, [0.03, 0.06, 0.02, 0.03, 0.06, 0.02], 0.2, shading, incidence)
    whole = collecting_area(panels, SUNS.reshape(20, 20, 3), 1e-7)
    parts = collecting_area(panels, Vector.of(SUNS), 1e-7)
    mapped = jax.vmap(lambda sun: collecting_area(panels, sun, 1e-7))(SUNS)
    assert whole.shape == (20, 20)
    np.testing.assert_allclose(whole.ravel(), parts, rtol=1e-13)
    np.testing.assert_allclose(mapped, parts, rtol=1e-13)


@pytest.mark.parametrize("smoothing", [0.0, 1e-5])
def test_gradient_by_differences(smoothing):
    panels = load_vehicle("hypso2").panels
    step = 1e-6
    toward = RNG.normal(size=SUNS.shape)
    slope = jax.jvp(
        lambda sun: collecting_area(panels, sun, smoothing), (SUNS,), (jnp.asarray(toward),)
    )[1]
    ahead = collecting_area(panels, SUNS + step * toward, smoothing)
    behind = collecting_area(panels, SUNS - step * toward, smoothing)
    np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * step), atol=1e-7)
    assert np.abs(slope).max() > 0.01


def test_smooth_area_tends_to_the_exact_one():
    panels = load_vehicle("hypso2").panels
    exact = np.asarray(collecting_area(panels, SUNS))
    errors = [
        np.abs(np.asarray(collecting_area(panels, SUNS, alpha)) - exact).max()
        for alpha in (1e-3, 1e-5, 1e-7)
    ]
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2] > 0.0
    # No corner gives a gradient that is not a number.
    edge = np.array([0.0, 0.0, 1.0])
    for alpha in (0.0, 1e-7):
        slope = jax.grad(lambda sun, a=alpha: collecting_area(panels, sun, a))(edge)
        assert np.isfinite(slope).all()


GOOD = {"normals": FACES, "area": np.full(6, 0.03), "efficiency": 0.2}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"normals": np.zeros((3, 6))}, r"normals: panel 1 has the normal \(0, 0, 0\); give"),
        ({"normals": np.eye(2)}, r"normals: has shape \(2, 2\); give three"),
        ({"area": [0.1] * 5}, r"area: has shape \(5,\), but there are 6 panels; give 6"),
        ({"area": [0.1] * 5 + [0.0]}, r"area: panel 6 has 0 m\^2; .*leave out faces"),
        ({"area": [-0.1] + [0.1] * 5}, r"area: panel 1 has -0.1 m\^2"),
        ({"efficiency": 20.0}, r"efficiency: holds 20; give the share"),
        ({"efficiency": 0.0}, r"efficiency: holds 0; .*greater than 0"),
        ({"shades": 6}, r"shades: is panel 7; there are 6"),
        ({"incidence": "flat"}, r"incidence: is 'flat'; allowed: cosine, cosine-squared"),
    ],
)
def test_bad_panels_are_refused(changes, words):
    with pytest.raises(FieldError, match=words):
        solar_panels(**{**GOOD, **changes})
