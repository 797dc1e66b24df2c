"""Axes of wheels given as azimuth and elevation."""

from __future__ import annotations

import numpy as np
import pytest

from jaxatt import scenarios

RNG = np.random.default_rng(1129)
PYRAMID = [45.0, 135.0, 225.0, 315.0]


def mounted(**wheels):
    changes = {f"vehicle.wheels.{key}": value for key, value in wheels.items()}
    return scenarios.replace(scenarios.load("mrp-k4-rk4"), changes)


def test_axes_are_turned_up_from_the_plane_and_about_z() -> None:
    azimuth, elevation = RNG.uniform(-180.0, 180.0, 4), RNG.uniform(20.0, 70.0, 4)
    axes = mounted(azimuth_deg=azimuth, elevation_deg=elevation).vehicle.wheels.axes
    np.testing.assert_allclose(np.degrees(np.arcsin(axes[2])), elevation)
    about = np.degrees(np.arctan2(axes[1], axes[0])) - azimuth
    np.testing.assert_allclose(about, np.zeros(4), atol=1e-10)


def test_one_elevation_is_a_pyramid_of_equal_axes() -> None:
    elevation = np.degrees(np.arcsin(1.0 / np.sqrt(3.0)))
    axes = mounted(azimuth_deg=PYRAMID, elevation_deg=elevation).vehicle.wheels.axes
    np.testing.assert_allclose(np.abs(axes), np.full((3, 4), 3.0**-0.5))
    np.testing.assert_allclose(axes @ axes.T, 4.0 / 3.0 * np.eye(3), atol=1e-12)


def test_either_form_replaces_the_other() -> None:
    angles = mounted(azimuth_deg=PYRAMID, elevation_deg=35.0)
    back = scenarios.replace(angles, {"vehicle.wheels.axes": np.eye(3)})
    np.testing.assert_array_equal(back.vehicle.wheels.axes, np.eye(3))


@pytest.mark.parametrize(
    ("wheels", "message"),
    [
        ({"azimuth_deg": PYRAMID}, r"elevation_deg: missing; add a line"),
        ({"elevation_deg": 35.0}, r"azimuth_deg: missing; add a line"),
        ({"azimuth_deg": 45.0, "elevation_deg": 35.0}, r"azimuth_deg = 45.0: is no list"),
        ({"azimuth_deg": PYRAMID, "elevation_deg": [1.0, 2.0]}, r"one number for all .* or 4"),
        ({"azimuth_deg": ["x"] * 4, "elevation_deg": 35.0}, r"azimuth_deg .*real numbers"),
        ({"azimuth_deg": PYRAMID, "elevation_deg": 0.0}, r"span 2 of the three directions"),
    ],
)
def test_what_makes_no_axes_is_refused(wheels, message: str) -> None:
    with pytest.raises(scenarios.ScenarioError, match=message):
        mounted(**wheels)


def test_both_forms_at_once_are_refused() -> None:
    document = dict(mounted(azimuth_deg=PYRAMID, elevation_deg=35.0).document)
    wheels = {**document["vehicle"]["wheels"], "axes": np.eye(3).tolist()}
    vehicle = {**document["vehicle"], "wheels": wheels}
    with pytest.raises(scenarios.ScenarioError, match=r"azimuth_deg = .*: given beside axes"):
        scenarios.from_mapping({**document, "vehicle": vehicle})
