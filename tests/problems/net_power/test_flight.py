"""The fine flight and its account of energy: against SciPy, by conservation, by refinement."""

import dataclasses

import jax
import numpy as np
import pytest
import scipy_flight
from printed_cases import FIRST, WHEEL_SPEED, chapter_4, eclipse_entry, hypso2
from scipy.interpolate import CubicSpline

from jaxatt.environment.along_orbit import evaluate
from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.light import Light
from jaxatt.problems.net_power.energy import EnergyAccount
from jaxatt.problems.net_power.flight import fly, fly_many
from jaxatt.problems.net_power.manoeuvre import Manoeuvre, Motion
from jaxatt.problems.net_power.satellite_surroundings import sunlight_at
from jaxatt.problems.reading.vehicles import load_vehicle
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.simulation.light_quadrature import light_weights, shares_of

SOLAR = 1e-6
"""Allowed relative difference of the solar energies."""


evaluated = jax.jit(evaluate, static_argnums=2, compiler_options=RUNS_ONCE)


def beside_scipy(manoeuvre, torque, dipole=None):
    """The package's flight, and the states and energies of SciPy's."""
    satellite = manoeuvre.satellite
    craft, wheels = satellite.craft, satellite.craft.wheels
    start, length = manoeuvre.start_time, manoeuvre.duration
    grid = np.linspace(start - 5.0, start + length + 5.0, int(length) + 11)
    along, _ = evaluated(satellite.orbit, satellite.torques, True, grid, satellite.light)
    field, down, sun = (
        CubicSpline(grid, np.asarray(v.array)) for v in (along.field, along.down, along.sun)
    )
    gradient = CubicSpline(grid, np.asarray(along.gradient))

    def light(times):
        return sunlight_at(satellite, np.asarray(times, float))[1]

    edges = scipy_flight.edges_of(light, start, start + length)
    fine = np.linspace(start, start + length, 800 * manoeuvre.intervals + 1)
    between = light(fine)
    jumps = np.abs(np.diff(between)) > 0.05

    def seen(t):
        k = min(int(np.searchsorted(fine, t, side="right")) - 1, len(jumps) - 1)
        if jumps[k]:
            return light([t])[0]
        share = (t - fine[k]) / (fine[k + 1] - fine[k])
        return (1.0 - share) * between[k] + share * between[k + 1]

    panels, coils = craft.panels, craft.magnetorquers

    def coil_power(m):
        if coils.full_power is not None:
            return float(np.abs(m).sum() / (3 * 0.34) * coils.full_power)
        current = m / (coils.turns * coils.coil_area)
        return float(np.sum(coils.resistance * current**2))

    efficiency = 1.0 if craft.battery is None else craft.battery.input_efficiency
    body = scipy_flight.Body(
        np.asarray(craft.inertia),
        np.asarray(wheels.axes),
        float(wheels.inertia[0]) if wheels.count else 1.0,
        float(wheels.efficiency) if wheels.count else 1.0,
        satellite.wheel_power,
        np.asarray(panels.normals),
        satellite.light.irradiance * efficiency * np.asarray(panels.efficiency * panels.area),
        panels.incidence_exponent,
        int(np.argmax(panels.shades)) if np.any(panels.shades) else None,
        np.asarray(satellite.torques.residual_dipole.dipole),
        float(satellite.torques.eddy_currents.coefficient),
        0.0 if satellite.momentum is None else satellite.momentum.gain,
        WHEEL_SPEED,
        0.34,
        coil_power,
        float(wheels.regeneration) if wheels.count else 0.0,
    )
    state = np.r_[manoeuvre.start.q_ib, manoeuvre.start.omega_ib, manoeuvre.start.omega_bw]
    held = np.zeros((manoeuvre.intervals, 3)) if dipole is None else dipole
    rows = scipy_flight.fly(
        body, state, manoeuvre.step, torque, held, field, down, gradient, sun, seen, edges, start
    )
    return fly(manoeuvre, torque[None], None if dipole is None else dipole[None]), rows


@pytest.mark.parametrize("penumbra", [0.2, None])
def test_energies_of_a_flight_into_the_shadow_agree_with_scipy(penumbra):
    satellite = hypso2(penumbra=penumbra)
    begin = eclipse_entry(satellite) - 10.31
    rng = np.random.default_rng(3)
    torque = rng.uniform(-2e-3, 2e-3, (10, 4))
    manoeuvre = Manoeuvre(satellite, FIRST, None, begin, 20.0, 10)
    ours, rows = beside_scipy(manoeuvre, torque)
    solar, wheels, coils = rows[-1, -3:]
    assert 1.0 < solar < 900.0
    assert abs(ours.energy.solar_J[0] / solar - 1.0) < SOLAR
    assert abs(ours.energy.wheels_J[0] / wheels - 1.0) < 1e-5
    assert abs(ours.energy.magnetorquers_J[0] / coils - 1.0) < 1e-5
    q = rows[:, :4] / np.linalg.norm(rows[:, :4], axis=1, keepdims=True)
    assert np.abs(ours.q_ib[0, 1:] - q).max() < 1e-8
    assert np.abs(ours.omega_bw[0, 1:] - rows[:, 7:11]).max() < 1e-6


@pytest.mark.parametrize("regeneration", [0.0, 0.6])
def test_solar_energy_of_a_tumbling_satellite_agrees_with_scipy(regeneration):
    """Fast enough that faces come into the light and leave it many times; every wheel by itself."""
    satellite = dataclasses.replace(hypso2(), wheel_power="wheels")
    panels = dataclasses.replace(satellite.craft.panels, incidence_exponent=1)
    wheels = dataclasses.replace(satellite.craft.wheels, regeneration=regeneration)
    craft = dataclasses.replace(satellite.craft, panels=panels, wheels=wheels)
    satellite = dataclasses.replace(satellite, craft=craft)
    start = Motion(np.array([0.5, 0.5, 0.5, 0.5]), np.array([0.1, -0.2, 0.15]), 0.01 * WHEEL_SPEED)
    torque = np.random.default_rng(5).uniform(-3e-3, 3e-3, (10, 4))
    ours, rows = beside_scipy(Manoeuvre(satellite, start, None, 100.0, 20.0, 10), torque)
    assert abs(ours.energy.solar_J[0] / rows[-1, -3] - 1.0) < SOLAR
    assert abs(ours.energy.wheels_J[0] / rows[-1, -2] - 1.0) < 1e-5


def test_given_dipoles_of_a_satellite_without_wheels_agree_with_scipy():
    satellite = dataclasses.replace(
        hypso2(), craft=load_vehicle("hypso1-magnetic"), momentum=None, decided_dipole=True
    )
    start = Motion(np.array([0.0, 0.0, 1.0, 0.0]), np.array([0.01, 0.0, -0.02]), np.zeros(0))
    manoeuvre = Manoeuvre(satellite, start, None, 50.0, 60.0, 3)
    dipole = np.random.default_rng(6).uniform(-0.34, 0.34, (3, 3))
    ours, rows = beside_scipy(manoeuvre, np.zeros((3, 0)), dipole)
    assert abs(ours.energy.solar_J[0] / rows[-1, -3] - 1.0) < SOLAR
    assert abs(ours.energy.magnetorquers_J[0] / rows[-1, -1] - 1.0) < 1e-9
    assert np.abs(ours.omega_ib[0, 1:] - rows[:, 4:7]).max() < 1e-9
    assert np.allclose(ours.strongest, np.abs(dipole).max(axis=0))


def test_signed_power_of_wheels_is_the_change_of_kinetic_energy():
    manoeuvre = chapter_4()
    torque = np.random.default_rng(1).uniform(-3.2e-3, 3.2e-3, (4, 80, 3))
    flown = fly(manoeuvre, torque)
    wheels = manoeuvre.satellite.craft.wheels
    body = np.asarray(manoeuvre.satellite.craft.inertia_without_spin)
    omega, speed = flown.omega_ib, flown.omega_bw
    kinetic = 0.5 * np.einsum("sni,ij,snj->sn", omega, body, omega)
    kinetic += 0.5 * np.sum(wheels.inertia * (speed + omega @ wheels.axes) ** 2, axis=-1)
    work = 0.85 * np.cumsum(flown.energy.wheels, axis=1)
    assert np.abs(work - kinetic[:, 1:]).max() < 1e-9
    assert np.abs(np.linalg.norm(flown.q_ib, axis=-1) - 1.0).max() < 1e-14


def test_twice_as_many_steps_change_nothing():
    manoeuvre = chapter_4()
    torque = np.random.default_rng(2).uniform(-3.2e-3, 3.2e-3, (8, 80, 3))
    once, twice = fly(manoeuvre, torque), fly(manoeuvre, torque, steps=40)
    assert np.abs(once.energy.solar_J / twice.energy.solar_J - 1.0).max() < 1e-8
    assert np.abs(once.q_ib - twice.q_ib).max() < 1e-10


def test_manoeuvres_flown_together_are_as_flown_alone():
    satellite = hypso2()
    later = dataclasses.replace(
        satellite, orbit=dataclasses.replace(satellite.orbit, days=satellite.orbit.days + 90.0)
    )
    cases = [
        Manoeuvre(satellite, FIRST, None, 0.0, 20.0, 10, load=13.5),
        Manoeuvre(later, FIRST, None, 2500.0, 30.0, 10, load=40.0),
    ]
    of = np.array([1, 0, 1])
    torque = np.random.default_rng(4).uniform(-2e-3, 2e-3, (3, 10, 4))
    together = fly_many(cases, of, torque)
    for lane, case in enumerate(of):
        alone = fly(cases[case], torque[lane : lane + 1])
        assert np.abs(together.q_ib[lane] - alone.q_ib[0]).max() < 1e-12
        assert np.allclose(together.energy.net[lane], alone.energy.net[0], rtol=1e-6, atol=1e-5)
        assert np.array_equal(together.light[lane], alone.light[0])
    assert together.energy.loads_J == pytest.approx([1200.0, 270.0, 1200.0])


def test_manoeuvres_of_different_length_are_refused():
    short = dataclasses.replace(chapter_4(), intervals=40)
    with pytest.raises(ValueError, match="must have the same number"):
        fly_many([chapter_4(), short], np.array([0, 1]), np.zeros((2, 80, 3)))


def test_manoeuvres_of_different_satellites_are_refused():
    case = chapter_4()
    other = dataclasses.replace(case.satellite, wheel_power="wheels")
    with pytest.raises(ValueError, match="another satellite"):
        fly_many(
            [case, dataclasses.replace(case, satellite=other)],
            np.array([0, 1]),
            np.zeros((2, 80, 3)),
        )


def test_a_sun_without_a_place_needs_a_date():
    manoeuvre = chapter_4()
    satellite = dataclasses.replace(manoeuvre.satellite, light=Light(1361.0))
    with pytest.raises(ValueError, match="sun must be fixed"):
        fly(dataclasses.replace(manoeuvre, satellite=satellite), np.zeros((1, 80, 3)))


def test_weights_of_the_light_integrate_across_its_edges():
    """Light that jumps twice in a step and falls slowly later, times a cubic."""

    def light(t):
        return np.where(t < 0.37, 1.0, np.where(t < 0.61, 0.2, 0.8 - 0.1 * t))

    steps, step = 3, 1.0
    halves = 0.5 * step * np.arange(2 * steps + 1)
    weights = light_weights(light, light(halves), 0.0, step, 4)
    points = step * (np.arange(steps)[:, None] + shares_of(8))
    dense = (np.arange(3_000_000) + 0.5) * 1e-6
    for power in (0, 1):
        exact = np.sum(light(dense) * dense**power) * 1e-6
        assert np.sum(weights * points**power) == pytest.approx(exact, abs=2e-4)
    # Without light to speak of they are the Gauss rule itself.
    plain = light_weights(np.ones_like, np.ones(2 * steps + 1), 0.0, step, 4)
    assert np.allclose(plain, step / plain.shape[1])
    assert np.sum(plain * points**3) == pytest.approx(3.0**4 / 4.0, rel=1e-14)


def test_a_full_battery_takes_no_more():
    solar = np.array([[10.0, 10.0, 0.0, 5.0]])
    loads = np.array([[1.0, 1.0, 6.0, 0.0]])
    none = np.zeros((1, 4))
    account = EnergyAccount(solar, none, none, loads, np.array([85.0]), 100.0)
    assert account.charge[0] == pytest.approx([85.0, 94.0, 100.0, 94.0, 99.0])
    assert account.net_J[0] == pytest.approx(17.0)
    assert account.least_charge[0] == pytest.approx(85.0)


def test_a_shadow_that_hides_everything_leaves_no_solar_energy():
    satellite = hypso2()
    dark = Light(1361.0, satellite.light.sun, Shadow(0.0, earth_radius=6.9e6))
    entry = eclipse_entry(dataclasses.replace(satellite, light=dark))
    manoeuvre = Manoeuvre(
        dataclasses.replace(satellite, light=dark), FIRST, None, entry + 120.0, 20.0, 10
    )
    flown = fly(manoeuvre, np.zeros((1, 10, 4)))
    assert flown.energy.solar_J[0] == 0.0
    assert np.all(flown.light == 0.0)
