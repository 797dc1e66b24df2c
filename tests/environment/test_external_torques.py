"""Each torque against its equation written out with NumPy, and the properties it must have."""

import datetime as dt

import jax.numpy as jnp
import numpy as np
import pytest

from jaxatt.attitude.components import Matrix, Quaternion, Vector
from jaxatt.environment import epoch, gravity_gradient, sun
from jaxatt.environment.aerodynamic_drag import Drag
from jaxatt.environment.eddy_currents import EddyCurrents
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.environment.precession import precession
from jaxatt.environment.residual_dipole import ResidualDipole
from jaxatt.environment.solar_radiation_pressure import SolarPressure


@pytest.fixture
def rng():
    return np.random.default_rng(41)


def test_drag_by_hand(rng):
    lever, velocity = rng.normal(size=(2, 3))
    drag = Drag(1.7741e-12, 0.06, 2.1, jnp.asarray(lever))
    speed = 7.6e3 * velocity
    force = -0.5 * 1.7741e-12 * 0.06 * 2.1 * np.linalg.norm(speed) * speed
    np.testing.assert_allclose(
        drag.torque(Vector.of(speed)).array, np.cross(lever, force), rtol=1e-12
    )


def test_air_turns_with_the_earth():
    drag = Drag(1.0, 1.0, 1.0, jnp.ones(3), epoch.EARTH_RATE)
    position, velocity = np.array([7e6, 0.0, 0.0]), np.array([0.0, 7.5e3, 0.0])
    relative = drag.air_speed(Vector.of(position), Vector.of(velocity)).array
    np.testing.assert_allclose(relative, [0.0, 7.5e3 - 7e6 * epoch.EARTH_RATE, 0.0], rtol=1e-12)


def test_solar_pressure_pushes_away_from_the_sun(rng):
    lever, direction = rng.normal(size=(2, 3))
    direction /= np.linalg.norm(direction)
    solar = SolarPressure(1367.0, 0.06, 0.2, jnp.asarray(lever), 3e8)
    expected = np.cross(lever, -1367.0 / 3e8 * 0.06 * 1.2 * 0.25 * direction)
    np.testing.assert_allclose(solar.torque(Vector.of(direction), 0.25).array, expected, rtol=1e-12)


def test_magnetic_torques_by_hand(rng):
    dipole, field, omega = rng.normal(size=(3, 3))
    found = ResidualDipole(jnp.asarray(dipole)).torque(Vector.of(field)).array
    np.testing.assert_allclose(found, np.cross(dipole, field), rtol=1e-12)
    eddy = EddyCurrents(3.0).torque(Vector.of(field), Vector.of(omega)).array
    np.testing.assert_allclose(eddy, -3.0 * np.cross(field, np.cross(omega, field)), rtol=1e-12)
    assert eddy @ omega < 0.0  # it brakes
    assert abs(eddy @ field) < 1e-12 * np.linalg.norm(eddy) * np.linalg.norm(field) * 10


def test_the_loop_has_the_same_gravity_gradient(rng):
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    inertia = np.diag([0.08, 0.1, 0.04]) + 1e-3
    expected = gravity_gradient.gravity_gradient_torque(
        jnp.asarray(q), jnp.array([7e6, 0.0, 0.0]), jnp.asarray(inertia)
    )
    down = Quaternion.of(q).rotate_inverse(Vector(0.0, 0.0, 1.0))
    gradient = 3.0 * 3.986004418e14 / 7e6**3
    found = gravity_gradient.tidal_torque(down, gradient, Matrix.of(inertia)).array
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_the_sum_is_the_sum_of_its_parts(rng):
    q = rng.normal(size=4)
    q = Quaternion.of(q / np.linalg.norm(q))
    vectors = [Vector.of(v) for v in rng.normal(size=(5, 3))]
    down, air, to_sun, field, omega = vectors
    along = Along(down, jnp.asarray(1e-6), air, to_sun, jnp.asarray(0.5), field, omega)
    parts = {
        "drag": Drag(1.0, 2.0, 3.0, jnp.asarray([1.0, 2.0, 3.0])),
        "solar_pressure": SolarPressure(1.0, 2.0, 0.1, jnp.asarray([1.0, 0.0, 2.0]), 1.0),
        "residual_dipole": ResidualDipole(jnp.asarray([0.1, 0.2, 0.3])),
        "eddy_currents": EddyCurrents(0.5),
    }
    inertia = Matrix.of(np.diag([1.0, 2.0, 2.5]))

    def total(**chosen):
        return np.asarray(ExternalTorques(**chosen).total(q, omega, along, inertia, None).array)

    rest = total()
    alone = sum(total(**{name: part}) - rest for name, part in parts.items())
    np.testing.assert_allclose(total(**parts), rest + alone, rtol=1e-12)


@pytest.mark.parametrize(
    ("moment", "right_ascension", "declination"),
    [
        # Astronomical Almanac: equinoxes and solstices.
        (dt.datetime(2020, 3, 20, 3, 50, tzinfo=dt.UTC), 0.0, 0.0),
        (dt.datetime(2022, 6, 21, 9, 14, tzinfo=dt.UTC), 90.0, 23.44),
        (dt.datetime(2024, 9, 22, 12, 44, tzinfo=dt.UTC), 180.0, 0.0),
    ],
)
def test_sun_at_equinoxes_and_solstices(moment, right_ascension, declination):
    days = jnp.asarray(epoch.days_since_j2000(moment))
    # The seasons belong to the equinox of the date.
    x, y, z = np.asarray(precession(days) @ sun.sun_direction(days))
    turned = (np.rad2deg(np.arctan2(y, x)) - right_ascension + 180.0) % 360.0 - 180.0
    # A minute, to which the Almanac rounds, is 0.0007 deg, and nutation as much as 0.005 deg.
    assert abs(turned) < 0.006
    assert abs(np.rad2deg(np.arcsin(z)) - declination) < 0.006


def test_eclipse():
    to_sun = jnp.broadcast_to(jnp.array([1.0, 0.0, 0.0]), (20001, 3))
    radius = 6.9e6
    angles = np.deg2rad(np.linspace(0.0, 180.0, 20001))
    r = radius * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    seen = np.asarray(sun.visible_fraction(jnp.asarray(r), to_sun))
    assert (np.diff(seen) <= 1e-12).all()
    assert seen[0] == 1.0 and seen[-1] == 0.0
    # A cylinder's shadow begins where the Earth's radius subtends the angle; the penumbra is 0.53
    # deg wide around it.
    edge = np.pi - np.arcsin(sun.EARTH_RADIUS / radius)
    assert abs(np.interp(-0.5, -seen, angles) - edge) < np.deg2rad(0.1)
    partly = angles[(seen > 0.0) & (seen < 1.0)]
    assert np.rad2deg(np.ptp(partly)) == pytest.approx(0.533, abs=0.02)


def test_rotation_angle_gains_a_turn_a_year_on_the_days():
    days = jnp.asarray([0.0, 1.0, 365.2421990741])
    angle = np.asarray(epoch.rotation_angle(days))
    assert np.rad2deg(angle[0]) == pytest.approx(280.46062, abs=1e-4)
    assert np.rad2deg(angle[1] - angle[0]) == pytest.approx(0.98564736, abs=1e-4)


def test_decimal_year_and_parse():
    moment = epoch.parse("2020-07-02T00:00:00")
    assert epoch.decimal_year(moment) == pytest.approx(2020.5, abs=1e-9)
    assert epoch.parse("2020-07-02T02:00:00+02:00") == moment
    with pytest.raises(ValueError):
        epoch.parse("soon")
