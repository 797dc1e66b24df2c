"""Read the table [orbit]: Keplerian elements, with J2 if asked for, or a TLE, OMM or OEM."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

import jax
import numpy as np

from jaxatt.environment import kepler
from jaxatt.environment.ephemeris import sampled
from jaxatt.environment.epoch import moment_text
from jaxatt.environment.kepler import KeplerianElements
from jaxatt.environment.orbit import MU_EARTH
from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.environment.orbit_data.formats import read_orbit_file
from jaxatt.environment.orbit_data.j2 import OblatePath, pole_of_date
from jaxatt.environment.orbit_data.mean_elements import osculating_state
from jaxatt.environment.orbit_data.path import OrbitDataError, OrbitPath
from jaxatt.environment.orbit_data.tle import element_set
from jaxatt.problems.reading.dates import read_epoch
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.orbit import ORBIT, SOURCES
from jaxatt.problems.scenario import Orbit
from jaxatt.problems.surroundings import elements_of
from jaxatt.runtime.settings import RUNS_ONCE

EARTH_RADIUS_KM = 6378.137  # equatorial, WGS 84
# Edge of the Earth's sphere of influence, rounded up: beyond it a distance was given in metres.
_LARGEST_AXIS_KM = 1e6
# The Earth's parameter is 3.986e14 m^3/s^2; far below it, km^3/s^2 were meant.
_SMALLEST_PARAMETER = 1e12

_BESIDE = ("epoch", "object")
_MARGIN = 600.0
"""[s] By which an orbit is sampled beyond the motion: environments are interpolated with it."""


def has_date(orbit: Mapping[str, Any]) -> bool:
    """Whether a table [orbit] says when the motion starts."""
    return any(key in orbit for key in ("epoch", *SOURCES))


def read_orbit(
    data: Any, origin: str, folder: Path | None, notes: list[str], days: float | None = None
) -> Orbit:
    """Read the orbit, in metres and radians.

    folder : where files are looked up.  notes : what is to be said is added.
    days : the start, since J2000, where another table has said it.
    Raises `ScenarioError`.
    """
    table = Table(data, origin, "[orbit]", ORBIT)
    start = read_epoch(table) if days is None else days
    given = [key for key in SOURCES if key in table]
    if given:
        return _from_source(table, given[0], start, folder, notes)
    if "object" in table:
        table.fail("object", "there is no file to look for it in", "drop it, or give tle_file")
    orbit = _from_elements(table, start)
    mean = table.choice("elements") == "mean"
    if table.choice("perturbations") == "none":
        if mean:
            table.fail(
                "elements",
                "an orbit without perturbations has no mean elements",
                'drop it, or add perturbations = "J2"',
            )
        return orbit
    mu, pole = orbit.gravitational_parameter, pole_of_date(start)
    with jax.enable_x64(True):
        elements = elements_of(orbit)
        r, v = osculating_state(elements, pole, mu) if mean else _state(elements, mu)
    path = OblatePath(np.asarray(r), np.asarray(v), start or 0.0, pole, mu)
    return _along(path, start, mu)


def on_date(
    orbit: Orbit, data: Any, origin: str, folder: Path | None, notes: list[str], days: float
) -> Orbit:
    """The orbit that begins at another moment; data : its table [orbit].

    A file is asked for that moment, and J2 goes on until then; an ellipse keeps its place among the
    stars.
    days : the moment, since J2000.  notes : what is to be said is added.
    Raises `ScenarioError` where the orbit is not known then.
    """
    if orbit.path is None:
        return dataclasses.replace(orbit, days=days)
    if not isinstance(orbit.path, OblatePath):
        return read_orbit(data, origin, folder, notes, days)
    (r,), (v,) = orbit.path.over(days, 0.0, 0.0)(np.zeros(1))
    path = dataclasses.replace(orbit.path, r=r, v=v, days=days)
    return _along(path, days, orbit.gravitational_parameter)


def covering(orbit: Orbit, data: Any, origin: str, last: float) -> Orbit:
    """The orbit, sampled for a motion of `last` [s] if it is no ellipse; data : its table.

    Raises `ScenarioError` where it is not known for so long.
    """
    if orbit.path is None:
        return orbit
    table = Table(data, origin, "[orbit]", ORBIT)
    key = next((key for key in ("epoch", *SOURCES) if key in table), "perturbations")
    if not math.isfinite(last):
        table.fail(
            key,
            "the orbit is sampled, and nothing says for how long",
            "give the longest final time as longest_s under [horizon]",
        )
    try:
        states = orbit.path.over(orbit.days or 0.0, 0.0, last)
        mu = orbit.gravitational_parameter
        return dataclasses.replace(orbit, motion=sampled(states, -_MARGIN, last + _MARGIN, mu))
    except OrbitDataError as error:
        _refuse(table, key, error)
    except ValueError as error:
        table.fail(key, str(error), "give another orbit")


def _from_source(
    table: Table, key: str, start: float | None, folder: Path | None, notes: list[str]
) -> Orbit:
    for other in table.data:
        if other not in (key, *_BESIDE):
            table.fail(other, f"given beside {key}", "keep one of the two and drop the other")
    wanted = table.text("object") if "object" in table else ""
    if wanted and key == "tle":
        table.fail("object", "two lines are of one satellite", "drop it, or give tle_file")
    path: ElementSet | Any
    try:
        if key == "tle":
            path = element_set(_lines(table))
        else:
            place = (folder or Path()) / table.text(key)
            path = read_orbit_file(place, key.removesuffix("_file"), wanted, start)
        if start is None:
            start = path.epoch
            notes.append(f"starts at the epoch of its orbit, {moment_text(start)}")
        if isinstance(path, ElementSet):
            warning = path.warning(start)
            if warning:
                notes.append(warning)
        return _along(path, start, MU_EARTH)
    except OrbitDataError as error:
        _refuse(table, key, error)


def _lines(table: Table) -> tuple[str, str]:
    given = table.texts("tle")
    return given[0], given[1]


def _refuse(table: Table, key: str, error: OrbitDataError) -> NoReturn:
    problem, _, mend = str(error).rpartition("; ")
    table.fail(key, problem, mend)


_state = jax.jit(kepler.to_state, compiler_options=RUNS_ONCE)
_elements = jax.jit(kepler.from_state, compiler_options=RUNS_ONCE)


def _along(path: OrbitPath, days: float | None, mu: float) -> Orbit:
    """The orbit along a path, with its osculating elements at the start."""
    r, v = path.over(days or 0.0, 0.0, 0.0)(np.zeros(1))
    with jax.enable_x64(True):
        found: KeplerianElements = _elements(r[0], v[0], mu)
    return Orbit(
        semi_major_axis=float(found.semi_major_axis),
        eccentricity=float(found.eccentricity),
        inclination=float(found.inclination),
        raan=float(found.raan),
        argument_of_periapsis=float(found.argument_of_perigee),
        true_anomaly=float(found.true_anomaly),
        gravitational_parameter=mu,
        days=days,
        path=path,
    )


def _from_elements(table: Table, days: float | None) -> Orbit:
    axis = table.number("semi_major_axis_km")
    if axis > _LARGEST_AXIS_KM:
        table.fail("semi_major_axis_km", "farther out than the Moon", "give kilometres, not metres")
    eccentricity = table.number("eccentricity")
    perigee = axis * (1.0 - eccentricity)
    if perigee <= EARTH_RADIUS_KM:
        table.fail(
            "semi_major_axis_km",
            f"the orbit passes below the Earth's surface (perigee {perigee:.6g} km from its "
            f"centre, radius {EARTH_RADIUS_KM} km)",
            "give the distance from the Earth's centre, not the altitude, in kilometres",
        )
    parameter = table.number("gravitational_parameter_m3_s2")
    if parameter < _SMALLEST_PARAMETER:
        table.fail(
            "gravitational_parameter_m3_s2",
            "too small for the Earth",
            "give m^3/s^2, 3.986e14 for the Earth, not km^3/s^2",
        )
    inclination = table.number("inclination_deg")
    raan, periapsis, anomaly = (
        math.radians(table.number(f"{key}_deg"))
        for key in ("raan", "argument_of_periapsis", "true_anomaly")
    )
    return Orbit(
        semi_major_axis=axis * 1e3,
        eccentricity=eccentricity,
        inclination=math.radians(inclination),
        raan=raan,
        argument_of_periapsis=periapsis,
        true_anomaly=anomaly,
        gravitational_parameter=parameter,
        days=days,
    )
