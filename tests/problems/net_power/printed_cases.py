"""Manoeuvres of Kristiansen (2023), chapters 4 and 5, typed in from the source for the tests."""

from __future__ import annotations

import datetime as dt

import numpy as np

from jaxatt.environment import epoch, igrf
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.eddy_currents import EddyCurrents
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.kepler import KeplerianElements
from jaxatt.environment.light import Light
from jaxatt.environment.motion import TwoBody
from jaxatt.environment.residual_dipole import ResidualDipole
from jaxatt.problems.net_power.manoeuvre import (
    End,
    Manoeuvre,
    MomentumManagement,
    Motion,
    Satellite,
)
from jaxatt.problems.net_power.satellite_surroundings import sunlight_at
from jaxatt.problems.reading.vehicles import load_vehicle

WHEEL_SPEED = np.array([209.4, 209.4, 209.4, -362.8])
FIRST = Motion(np.array([0.0, 0.0, 1.0, 0.0]), np.array([-0.01, 0.02, 0.01]), WHEEL_SPEED)
IMAGING = np.deg2rad([0.0, -0.754, 0.0])
TASKS = (
    # start [s], length [s], attitude to end in, whether imaging follows, energy of the PD law [J]
    (0.0, 100.0, [0.853, 0.372, -0.019, -0.366], False, 1849.0),
    (220.0, 40.0, [0.084, 0.918, -0.329, -0.205], True, 365.0),
    (320.0, 60.0, [0.297, -0.858, 0.407, 0.102], True, 567.4),
    (440.0, 20.0, [0.275, 0.860, -0.262, -0.343], True, -18.8),
    (520.0, 310.0, [0.827, 0.123, 0.333, -0.435], False, 6507.5),
    (922.0, 388.0, [0.034, 0.710, 0.474, 0.519], True, 8241.7),
    (1370.0, 4380.0, [0.677, 0.642, -0.151, -0.327], False, 25539.8),
    (5930.0, 40.0, [0.405, -0.835, 0.372, -0.018], True, 131.8),
    (6030.0, 60.0, [0.389, -0.828, 0.402, 0.036], True, 469.3),
    (6150.0, 304.0, [0.223, 0.906, -0.304, -0.195], False, 5938.8),
)


def chapter_4(intervals: int = 80) -> Manoeuvre:
    """The turn of table 4.1, its target as a constraint."""
    light = Light(1361.0, np.array([0.2673, 0.5345, 0.8018]))
    satellite = Satellite(load_vehicle("hypso1-solar"), light, wheel_power="signed")
    rest, still = np.zeros(3), np.zeros(3)
    end = End(np.array([0.0, 1.0, 0.0, 0.0]), rest, np.deg2rad(0.01), 1e-5)
    return Manoeuvre(
        satellite, Motion(np.array([0.0, 0.0, 1.0, 0.0]), rest, still), end, 0.0, 40.0, intervals
    )


def hypso2(gain: float = 5.0, penumbra: float | None = 0.2) -> Satellite:
    """The satellite of chapter 5; its date is that of figure 5.5."""
    moment = dt.datetime(2023, 3, 14, 9, 31, 11, tzinfo=dt.UTC)
    degrees = np.deg2rad([97.439, 139.3136, 213.7547 - 180.0, 54.0])
    elements = KeplerianElements(*map(np.asarray, (6905.1e3, 0.0007757, *degrees)))
    orbit = OrbitTask(
        TwoBody(elements, 3.986e14),
        epoch.days_since_j2000(moment),
        igrf.at_year(epoch.decimal_year(moment)),
    )
    return Satellite(
        load_vehicle("hypso2"),
        Light(1361.0, 1.49599870e11 * np.array([0.8944, 0.0, 0.4472]), Shadow(penumbra)),
        orbit,
        ExternalTorques(
            residual_dipole=ResidualDipole(np.full(3, 12e-3)), eddy_currents=EddyCurrents(0.01)
        ),
        gravity_gradient=True,
        momentum=MomentumManagement(gain, WHEEL_SPEED),
        wheel_power="body",
    )


def chapter_5(task: int, start: Motion, satellite: Satellite | None = None) -> Manoeuvre:
    """Task 1 to 10 from a given start, in intervals of 2 s."""
    begin, length, q_ib, images, _ = TASKS[task - 1]
    attitude = np.asarray(q_ib) / np.linalg.norm(q_ib)
    rate = IMAGING if images else np.zeros(3)
    return Manoeuvre(
        satellite or hypso2(),
        start,
        End(attitude, rate, np.deg2rad(0.1), 1e-4),
        begin,
        length,
        round(length / 2.0),
        load=13.5,
    )


def eclipse_entry(satellite: Satellite) -> float:
    """Time [s] at which the light first falls below one half after its start."""
    times = np.arange(0.0, 6000.0, 2.0)
    light = sunlight_at(satellite, times)[1]
    return float(times[np.flatnonzero((light[1:] < 0.5) & (light[:-1] >= 0.5))[0]])
