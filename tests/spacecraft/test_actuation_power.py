"""Power of wheels and magnetorquers, by hand and by the kinetic energy of a wheel."""

import jax
import numpy as np
import pytest
from scipy.integrate import quad

from jaxatt.scenarios import load_vehicle
from jaxatt.spacecraft import FieldError, magnetorquers, reaction_wheels
from jaxatt.spacecraft.actuation_power import drive_power, magnetorquer_power, wheel_power

RNG = np.random.default_rng(15)
SKEW = np.hstack([np.eye(3), np.full((3, 1), 1.0 / np.sqrt(3.0))])
TORQUE, SPEED = RNG.normal(size=(2, 30, 4)) * np.array([3e-3, 300.0])[:, None, None]


def wheels(**drive):
    return reaction_wheels(SKEW, 2.1e-4, 3.2e-3, **{"efficiency": 0.85, **drive})


def test_one_magnitude_over_body_axes_as_printed():
    found = wheel_power(wheels(), TORQUE, SPEED, "body")
    expected = [
        abs((SKEW @ torque) @ (SKEW @ speed)) / 0.85
        for torque, speed in zip(TORQUE, SPEED, strict=True)
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    # Wheels that work against each other about one axis cost nothing by that formula.
    against = np.array([1e-3, 0.0, 0.0, 0.0]), np.array([0.0, 100.0, 0.0, 0.0])
    assert wheel_power(wheels(), *against, "body") == 0.0


def test_wheel_by_wheel():
    found = wheel_power(wheels(), TORQUE, SPEED, "wheels")
    np.testing.assert_allclose(found, np.abs(TORQUE * SPEED).sum(axis=1) / 0.85, rtol=1e-12)
    ideal = wheels(efficiency=1.0, regeneration=1.0)
    signed = wheel_power(ideal, TORQUE, SPEED, "signed")
    np.testing.assert_allclose(wheel_power(ideal, TORQUE, SPEED, "wheels"), signed, atol=1e-13)
    assert (wheel_power(ideal, TORQUE, SPEED, "wheels") < found).all()


@pytest.mark.parametrize("regeneration", [0.0, 0.3, 1.0])
def test_drive_power_is_the_larger_of_two_lines(regeneration):
    drives = wheels(regeneration=regeneration)
    mechanical = np.linspace(-1.0, 1.0, 41)
    found = drive_power(drives, mechanical)
    lines = mechanical / 0.85, -mechanical * drives.braking_cost
    np.testing.assert_allclose(found, np.maximum(*lines), atol=1e-15)
    braking = (1.0 - regeneration) / 0.85 - 0.85 * regeneration
    assert found[0] == pytest.approx(braking)


def test_signed_power_is_the_change_of_kinetic_energy():
    """A wheel of fixed axis: tau w is d(J w^2 / 2)/dt, so there and back costs nothing."""
    one, inertia = wheels(), 2.1e-4
    speed = lambda t: 200.0 + 150.0 * np.sin(0.3 * t)  # noqa: E731
    torque = lambda t: inertia * 45.0 * np.cos(0.3 * t)  # noqa: E731

    def power(t, model):
        driven = np.array([1.0, 0.0, 0.0, 0.0])
        return float(wheel_power(one, torque(t) * driven, speed(t) * driven, model))

    gained = 0.5 * inertia * (speed(5.0) ** 2 - speed(0.0) ** 2)
    assert quad(power, 0.0, 5.0, args=("signed",))[0] == pytest.approx(gained / 0.85, rel=1e-9)
    assert quad(power, 0.0, 2.0 * np.pi / 0.3, args=("signed",))[0] == pytest.approx(0.0, abs=1e-9)
    whole = quad(power, 0.0, 2.0 * np.pi / 0.3, args=("wheels",), points=[5.236, 15.708])[0]
    top = 0.5 * inertia * (350.0**2 - 50.0**2)
    assert whole == pytest.approx(2.0 * top / 0.85, rel=1e-6)


@pytest.mark.parametrize("model", ["signed", "body", "wheels"])
def test_smooth_power_tends_to_the_exact_one_and_has_a_gradient(model):
    drives = wheels()
    exact = np.asarray(wheel_power(drives, TORQUE, SPEED, model))
    smooth = np.asarray(wheel_power(drives, TORQUE, SPEED, model, 1e-10))
    np.testing.assert_allclose(smooth, exact, atol=1e-4)
    still = np.zeros(4)
    slope = jax.grad(lambda torque: wheel_power(drives, torque, still, model))(still)
    assert np.isfinite(slope).all()


def test_unknown_model_is_refused():
    with pytest.raises(ValueError, match=r"wheel power: 'motor' .*allowed: signed, body, wheels"):
        wheel_power(wheels(), TORQUE, SPEED, "motor")


def test_magnetorquers_by_full_power():
    """Kristiansen (2023), eq. (5.6) with the values of table 5.5."""
    coils = load_vehicle("hypso2").magnetorquers
    assert magnetorquer_power(coils, np.array([0.34, -0.34, 0.34])) == pytest.approx(2.52)
    assert magnetorquer_power(coils, np.array([0.0, -0.17, 0.0])) == pytest.approx(0.42)


def test_magnetorquers_by_resistance():
    """Eqs. (6.7) and (6.9) with table 6.2; three saturated axes draw the power of table 5.5."""
    coils = load_vehicle("hypso1-magnetic").magnetorquers
    assert magnetorquer_power(coils, np.array([0.34, -0.34, 0.34])) == pytest.approx(2.52, rel=1e-6)
    dipole = RNG.uniform(-0.3, 0.3, (7, 3))
    current = dipole / (1.1e5 * np.pi * 5e-3**2)
    expected = (current**2).sum(axis=1) * 542.3587
    np.testing.assert_allclose(magnetorquer_power(coils, dipole), expected, rtol=1e-9)
    assert magnetorquer_power(magnetorquers(0.3), dipole[0]) == 0.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"full_power": 1.0, "turns": 10.0}, r"full_power: is given beside .*; keep one"),
        ({"turns": 10.0, "coil_area": 1e-4}, r"resistance: is missing; .*all three"),
        ({"full_power": 0.0}, r"full_power: is 0.0; .*greater than 0"),
        ({"turns": 10.0, "coil_area": -1.0, "resistance": 1.0}, r"coil_area: holds -1; every"),
    ],
)
def test_bad_magnetorquers_are_refused(given, words):
    with pytest.raises(FieldError, match=words):
        magnetorquers(0.3, **given)


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"efficiency": 0.0}, r"efficiency: is 0.0; .*greater than 0"),
        ({"efficiency": 85}, r"efficiency: is 85; .*at most 1"),
        ({"regeneration": -0.1}, r"regeneration: is -0.1; .*from 0"),
    ],
)
def test_bad_drives_are_refused(drive, words):
    with pytest.raises(FieldError, match=words):
        wheels(**drive)
