"""Tasks of prescribed attitude, against an integration by SciPy in plain NumPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from jaxatt.environment import igrf
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.light import Light
from jaxatt.environment.residual_dipole import ResidualDipole
from jaxatt.problems.net_power.along_flight import along_flight
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, MomentumManagement, Motion, Satellite
from jaxatt.problems.net_power.plan.hold import fly_held
from jaxatt.problems.reading.orbit import read_orbit
from jaxatt.problems.reading.vehicles import load_vehicle
from jaxatt.problems.surroundings import motion_of

ORBIT = read_orbit(
    {
        "semi_major_axis_km": 6905.1,
        "eccentricity": 7.757e-4,
        "inclination_deg": 97.439,
        "raan_deg": 139.3136,
        "argument_of_periapsis_deg": 33.7547,
        "true_anomaly_deg": 54.0,
        "epoch": "2023-03-14T09:31:11Z",
    },
    "test",
    None,
    [],
)
REFERENCE = np.array([209.4, 209.4, 209.4, -362.8])
CRAFT = load_vehicle("hypso2")
SUN = 1.4959987e11 * np.array([0.8944, 0.0, 0.4472])


def satellite():
    flown = OrbitTask(motion_of(ORBIT), ORBIT.days, igrf.at_year(2023.2))
    return Satellite(
        CRAFT,
        Light(1361.0, SUN, Shadow()),
        orbit=flown,
        torques=ExternalTorques(residual_dipole=ResidualDipole(np.full(3, 0.012))),
        gravity_gradient=True,
        momentum=MomentumManagement(5.0, REFERENCE),
        wheel_power="body",
    )


def imaging(speeds, start=380.0, duration=60.0, intervals=30):
    q = np.array([0.297, -0.858, 0.407, 0.102])
    motion = Motion(q / np.linalg.norm(q), np.array([0.0, np.deg2rad(-0.754), 0.0]), speeds)
    return Manoeuvre(satellite(), motion, None, start, duration, intervals, load=29.5, charge=1e5)


def independent(manoeuvre, rate):
    """Speeds at the end, and energies of panels, wheels and magnetorquers [J]."""
    wheels, battery = CRAFT.wheels, CRAFT.battery
    axes, inertia = np.asarray(wheels.axes), np.asarray(CRAFT.inertia)
    spin, speeds = np.asarray(wheels.inertia), manoeuvre.start.omega_bw
    around = along_flight(manoeuvre, manoeuvre.intervals + 1, 1, 2)
    times = manoeuvre.step * np.arange(manoeuvre.intervals + 1)
    first = Rotation.from_quat(np.roll(manoeuvre.start.q_ib, -1))

    def field_at(table, t):
        return np.array([np.interp(t, times, part) for part in table])

    def at(t, h):
        back = (first * Rotation.from_rotvec(rate * t)).inv()
        field = back.apply(field_at(around.field, t))
        error = h - axes @ (spin * REFERENCE)
        dipole = np.clip(5.0 / np.linalg.norm(field) * np.cross(error, field), -0.34, 0.34)
        down = back.apply(field_at(down_at, t))
        gravity = np.interp(t, times, gradient) * np.cross(down, inertia @ down)
        external = np.cross(dipole + 0.012, field) + gravity
        torque = external - np.cross(rate, inertia @ rate + h)
        speed = speeds + np.linalg.pinv(axes) @ (h - axes @ (spin * speeds)) / spin
        sun = back.apply(field_at(around.sun, t))
        return torque, dipole, np.linalg.pinv(axes) @ torque, speed, sun

    steps = around.steps.along
    down_at = [part[:, 0, 0] for part in steps.down.parts]
    gradient = steps.gradient[:, 0, 0]

    def rates(t, y):
        torque, dipole, on_wheels, speed, sun = at(t, y[:3])
        power = np.abs((axes @ on_wheels) @ (axes @ speed)) / 0.85
        lit = np.maximum([sun[0], sun[1], -sun[0], -sun[1]], 0.0) ** 2
        shaded = np.array([1.0 - max(sun[1], 0.0), 1.0, *[1.0 - max(sun[1], 0.0)] * 2])
        area = 0.2 * np.array([0.024, 0.144, 0.024, 0.048]) @ (lit * shaded)
        coils = 2.52 * np.abs(dipole).sum() / (3 * 0.34)
        return [*torque, 1361.0 * battery.input_efficiency * area, power, coils]

    begun = [*(axes @ (spin * speeds)), 0.0, 0.0, 0.0]
    end = solve_ivp(
        rates, (0.0, manoeuvre.duration), begun, rtol=1e-10, atol=1e-12, max_step=1.0
    ).y[:, -1]
    return at(manoeuvre.duration, end[:3])[3], end[3:]


@pytest.mark.parametrize("bias", [0.0, 60.0])
def test_imaging_against_scipy(bias):
    """Attitude turns at its rate, and the wheels do what that needs; bias : more of wheel 1."""
    rate = np.array([0.0, np.deg2rad(-0.754), 0.0])
    manoeuvre = imaging(REFERENCE + np.array([bias, 0.0, 0.0, 20.0]))
    flown = fly_held([manoeuvre], rate[None])
    speeds, (solar, wheels, coils) = independent(manoeuvre, rate)
    np.testing.assert_allclose(flown.omega_bw[0, -1], speeds, atol=1e-5)
    assert flown.energy.solar_J[0] == pytest.approx(solar, rel=1e-6)
    assert flown.energy.wheels_J[0] == pytest.approx(wheels, rel=1e-4)
    assert flown.energy.magnetorquers_J[0] == pytest.approx(coils, rel=1e-4)
    assert flown.energy.loads_J[0] == pytest.approx(29.5 * 60.0)
    turned = Rotation.from_quat(np.roll(manoeuvre.start.q_ib, -1)) * Rotation.from_rotvec(
        rate * 60.0
    )
    along = np.abs(np.roll(turned.as_quat(), 1) @ flown.q_ib[0, -1])
    assert along == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(flown.omega_ib[0], np.tile(rate, (31, 1)), atol=1e-15)


def test_a_difference_of_rate_goes_into_the_wheels():
    """Total momentum stays as it is when the body is stopped at once."""
    manoeuvre = imaging(REFERENCE, intervals=4, duration=8.0)
    flown = fly_held([manoeuvre], np.zeros((1, 3)))
    wheels = CRAFT.wheels
    before = CRAFT.inertia @ manoeuvre.start.omega_ib + wheels.axes @ (wheels.inertia * REFERENCE)
    after = wheels.axes @ (wheels.inertia * flown.omega_bw[0, 0])
    np.testing.assert_allclose(after, before, atol=1e-15)
    np.testing.assert_allclose(np.abs(flown.q_ib[0] @ manoeuvre.start.q_ib), np.ones(5), atol=1e-14)


def test_several_at_once_are_those_one_by_one():
    rates = np.deg2rad([[0.0, -0.754, 0.0], [0.3, 0.0, 0.1]])
    several = [imaging(REFERENCE), imaging(REFERENCE + 30.0, start=3500.0)]
    together = fly_held(several, rates)
    for k, one in enumerate(several):
        alone = fly_held([one], rates[k : k + 1])
        np.testing.assert_allclose(together.omega_bw[k], alone.omega_bw[0], rtol=1e-12)
        np.testing.assert_allclose(together.energy.net[k], alone.energy.net[0], rtol=1e-10)
    assert together.light[1].max() == 0.0  # in the umbra
    assert together.energy.solar_J[1] == 0.0
