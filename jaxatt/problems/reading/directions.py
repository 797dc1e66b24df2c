"""Read the directions that body axes are pointed along, or kept away from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import jax
import numpy as np

from jaxatt.environment import igrf, toward
from jaxatt.environment.epoch import SECONDS_PER_DAY, decimal_year
from jaxatt.environment.motion import Motion
from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.environment.sun import EARTH_RADIUS
from jaxatt.problems.reading.dates import MAGNETIC_FIELD, SUNLIGHT, DatedModel, beyond, moment_of
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.problems.reading.tables.attitude import DIRECTION_KEYS, GIVEN
from jaxatt.problems.scenario import Orbit
from jaxatt.problems.surroundings import motion_of
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.spacecraft.checks import Float64

_NEEDS_ORBIT = ("nadir", "velocity", "field", "site", "satellite", "direction_orbit")
_NEEDS_DATE = ("sun", "field", "site")
_OWN_KEYS = {
    "right_ascension_deg": ("declination_deg",),
    "site": ("latitude_deg", "longitude_deg", "height_m"),
    "satellite": ("satellite",),
}
"""Keys that have a meaning with one kind of direction only."""

_SAME_PLACE = 1.0
"""[m] Within which two orbits are taken for one."""

_elevation = jax.jit(toward.ToSite.elevation, compiler_options=RUNS_ONCE)
_from_here = jax.jit(toward.ToSatellite.from_here, compiler_options=RUNS_ONCE)


@dataclass(frozen=True, eq=False)
class Sky:
    """What a satellite may be pointed at, and the axes that its attitudes refer to.

    motion : along the orbit; None without one.  days : time zero, since J2000; None without a date.
    sun : (3,), a fixed sun in inertial axes; None for the true one.
    frame : "orbit" or "inertial".  folder : where files are looked up.
    without_orbit : what to do where there is no orbit to tell a direction by.
    doubt : sentence on how far the orbit may be off; empty where nothing is known against it.
    """

    frame: str = "inertial"
    motion: Motion | None = None
    days: float | None = None
    sun: Floats | None = None
    folder: Path | None = None
    without_orbit: str = "add [orbit], or give direction_inertial"
    doubt: str = ""


def sky_over(
    orbit: Orbit | None,
    folder: Path | None,
    frame: str = "orbit",
    days: float | None = None,
    sun: Floats | None = None,
) -> Sky:
    """What is over a spacecraft on an orbit, whatever precision JAX is set to.

    frame : that attitudes refer to; without an orbit they are inertial.  days : of time zero,
    since J2000, where the orbit does not say it.
    """
    if orbit is None:
        return Sky("inertial", None, days, sun, folder)
    with jax.enable_x64(True):
        motion = motion_of(orbit)
    path, start = orbit.path, orbit.days if days is None else days
    doubt = path.warning(start) if isinstance(path, ElementSet) and start is not None else ""
    return Sky(frame, motion, start, sun, folder, doubt=doubt)


class Aim(NamedTuple):
    """A body axis, and the direction that it is asked to have.

    key : of its table.  words : the direction, for messages.
    """

    key: str
    body: Float64
    direction: toward.Direction
    words: str


def read_aim(whole: Table, key: str, notes: list[str], sky: Sky, last: float) -> Aim:
    """Read a body axis with its direction, for a motion of `last` [s].

    key : of `whole` under which both stand.  Raises `ScenarioError`.
    """
    table = Table(whole.data[key], whole.origin, f"{whole.label} {key}", DIRECTION_KEYS)
    body = table.direction("body")
    return Aim(key, body, *read_direction(table, notes, sky, last))


def read_direction(
    table: Table, notes: list[str], sky: Sky, last: float
) -> tuple[toward.Direction, str]:
    """Read a direction for a motion of `last` [s], and what messages call it.

    Raises `ScenarioError`.
    """
    given = table.one_of(GIVEN)
    kind = table.choice("toward") if given == "toward" else given
    _check_keys(table, kind)
    _check_known(table, kind, given, sky, last)
    return _direction(table, kind, notes, sky, last)


def check_sight(
    table: Table, key: str, seen: tuple[toward.Direction, str], sky: Sky, time: float
) -> None:
    """Refuse a place on the ground from which the satellite is below the horizon at a time [s], and
    another satellite behind the Earth.

    key : that messages name.  seen : the direction, and what messages call it.
    """
    direction, words = seen
    if isinstance(direction, toward.ToSatellite):
        _check_clear(table, key, direction, sky, time)
    if not isinstance(direction, toward.ToSite):
        return
    with jax.enable_x64(True):
        angle = math.degrees(float(_elevation(direction, float(time))))
    if angle <= 0.0:
        when = moment_of(_days(sky) + time / SECONDS_PER_DAY)
        place = (math.degrees(float(x)) for x in (direction.latitude, direction.longitude))
        mend = "move the manoeuvre in time, or check the place and the orbit"
        table.fail(
            key,
            f"{words} is out of sight: the satellite stands {angle:.2f} deg above its "
            f"horizon at {when:%Y-%m-%dT%H:%M:%SZ}",
            "; ".join(filter(None, (as_radians(*place), sky.doubt, mend))),
        )


def _check_clear(
    table: Table, key: str, direction: toward.ToSatellite, sky: Sky, time: float
) -> None:
    """Refuse a satellite that the Earth hides, or that is this one."""
    with jax.enable_x64(True):
        here, away = map(np.asarray, _from_here(direction, float(time)))
    height, distance = (float(np.linalg.norm(part)) for part in (here, away))
    when = f"{moment_of(_days(sky) + time / SECONDS_PER_DAY):%Y-%m-%dT%H:%M:%SZ}"
    if distance < _SAME_PLACE:
        table.fail(
            key,
            f"the other satellite is {distance:.3g} m away at {when}, which gives no direction",
            "give the orbit of another one",
        )
    below = math.asin(min(1.0, EARTH_RADIUS / height))
    nadir = math.acos(max(-1.0, min(1.0, float(-(here @ away)) / (height * distance))))
    if nadir < below and distance > height * math.cos(below):
        table.fail(
            key,
            f"the other satellite is out of sight: it stands {math.degrees(below - nadir):.2f} deg "
            f"below the Earth's edge at {when}",
            "move the manoeuvre in time, or check the orbits",
        )


def as_radians(latitude: float, longitude: float) -> str:
    """Sentence on a place [deg] whose angles may have been meant as radians; empty for others."""
    small = all(abs(x) <= math.pi for x in (latitude, longitude))
    # Nobody writes radians that are whole numbers.
    if not small or any(round(x, 9).is_integer() for x in (latitude, longitude)):
        return ""
    return (
        f"latitude {latitude:g} and longitude {longitude:g} are taken as degrees; as radians they "
        f"would be {math.degrees(latitude):.4g} and {math.degrees(longitude):.4g} deg"
    )


def _direction(
    table: Table, kind: str, notes: list[str], sky: Sky, last: float
) -> tuple[toward.Direction, str]:
    """A direction, and what messages call it."""
    if kind == "direction_inertial":
        return toward.AmongStars(table.direction(kind)), "the direction"
    if kind == "right_ascension_deg":
        ra = math.radians(table.number("right_ascension_deg"))
        dec = math.radians(table.number("declination_deg"))
        x, y = math.cos(dec) * math.cos(ra), math.cos(dec) * math.sin(ra)
        return toward.AmongStars(np.array([x, y, math.sin(dec)])), "the direction"
    if kind == "sun":
        fixed = None if sky.sun is None else toward.AmongStars(sky.sun)
        return fixed or toward.ToSun(_days(sky)), "the sun"
    motion = sky.motion
    assert motion is not None
    if kind == "direction_orbit":
        return toward.InOrbitAxes(table.direction(kind), motion), "the direction"
    if kind == "nadir":
        return toward.InOrbitAxes(np.array([0.0, 0.0, 1.0]), motion), "the nadir"
    if kind == "velocity":
        return toward.AlongVelocity(motion), "the velocity"
    if kind == "field":
        model = igrf.at_year(decimal_year(moment_of(_days(sky))))
        return toward.AlongField(motion, _days(sky), model), "the magnetic field"
    if kind == "satellite":
        return _to_satellite(table, notes, sky, last), "the other satellite"
    return _to_site(table, notes, sky)


def _to_site(table: Table, notes: list[str], sky: Sky) -> tuple[toward.Direction, str]:
    assert sky.motion is not None
    latitude = table.number("latitude_deg")
    longitude = table.number("longitude_deg")
    height = table.number("height_m")
    if doubtful := as_radians(latitude, longitude):
        notes.append(f"{table.label}: {doubtful}")
    at = (math.radians(latitude), math.radians(longitude), height)
    words = f"the place {latitude:g}, {longitude:g} deg"
    return toward.ToSite(sky.motion, _days(sky), *at), words


def _to_satellite(table: Table, notes: list[str], sky: Sky, last: float) -> toward.Direction:
    assert sky.motion is not None
    data = table.require("satellite")
    other = read_orbit(
        data, f"{table.origin}: {table.label} satellite", sky.folder, notes, sky.days
    )
    other = covering(other, data, f"{table.origin}: {table.label} satellite", last)
    with jax.enable_x64(True):
        return toward.ToSatellite(sky.motion, motion_of(other))


def _check_keys(table: Table, kind: str) -> None:
    """Refuse keys that belong to another kind of direction."""
    for other, keys in _OWN_KEYS.items():
        for key in keys:
            if other != kind and key in table:
                table.fail(key, f"has no meaning with {kind}", "drop it")


def _check_known(table: Table, kind: str, key: str, sky: Sky, last: float) -> None:
    """Refuse a direction that nobody knows without orbit, date or model."""
    dated = kind in _NEEDS_DATE and not (kind == "sun" and sky.sun is not None)
    # Without an orbit only a flight has a date.
    if sky.motion is None and (kind in _NEEDS_ORBIT or (dated and sky.days is None)):
        table.fail(key, "needs an orbit", sky.without_orbit)
    if not dated:
        return
    if sky.days is None:
        table.fail(key, "needs the date", 'add a line such as epoch = "2026-06-21T12:00:00Z"')
    model: DatedModel | None = {"sun": SUNLIGHT, "field": MAGNETIC_FIELD}.get(kind)
    outside = beyond(model, sky.days, last) if model else ""
    if model and outside:
        problem = f"needs {model.name}; {outside}, which is known between them"
        table.fail(key, problem, "give a date within")


def _days(sky: Sky) -> float:
    assert sky.days is not None
    return sky.days
