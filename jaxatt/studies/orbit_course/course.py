"""Positions, ground track, light, sun and field along an orbit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import epoch, ground, igrf
from jaxatt.environment.along_orbit import OrbitTask, evaluate
from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.eclipse_times import Eclipse, eclipses
from jaxatt.environment.ellipsoid import EQUATORIAL_RADIUS
from jaxatt.environment.external import ExternalTorques
from jaxatt.environment.light import Light
from jaxatt.environment.orbit_data.oem import EphemerisTable
from jaxatt.problems.reading.dates import MAGNETIC_FIELD, SUNLIGHT, check_epoch, moment_of
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.orbit import covering
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.surroundings import motion_of
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE
from jaxatt.studies.orbit_course.reading import KnownOrbit

_BLOCK = 1024  # instants of one evaluation
_INSTANTS = 180  # of a revolution
_MOST = 1_000_000
REVOLUTIONS = 3
"""How long a course is unless somebody says it."""


@dataclass(frozen=True, eq=False)
class Course:
    """What an orbit brings at some times.

    known : the orbit.  times : (n,) [s] after its epoch.
    position : (n, 3) [m] and velocity : (n, 3) [m/s], in inertial axes.
    attitude : (n, 4), q_io, and rate : (n, 3) [rad/s], omega_io in orbit axes, of the orbit frame.
    latitude, longitude : (n,) [rad], geodetic, below the satellite.  altitude : (n,) [m].
    sun : (n, 3), unit vectors to the sun in inertial axes.  light : (n,), share of the sun's disk.
    beta : (n,) [rad], angle of the sun above the plane of the orbit.
    field : (n, 3) [T] in inertial axes; None outside the dates of the model.
    eclipses : the passages through the shadow.
    """

    known: KnownOrbit
    times: Floats
    position: Floats
    velocity: Floats
    attitude: Floats
    rate: Floats
    latitude: Floats
    longitude: Floats
    altitude: Floats
    sun: Floats
    light: Floats
    beta: Floats
    field: Floats | None
    eclipses: tuple[Eclipse, ...]

    @property
    def dark(self) -> float:
        """Share of the time in the shadow, half-shadow by its share."""
        return float(1.0 - np.trapezoid(self.light, self.times) / self.times[-1])


def period_of(known: KnownOrbit) -> float:
    """Time [s] of a revolution by the osculating elements at the start."""
    orbit = known.orbit
    return 2.0 * math.pi * math.sqrt(orbit.semi_major_axis**3 / orbit.gravitational_parameter)


def course_of(known: KnownOrbit, duration: float | None = None) -> Course:
    """Follow an orbit for some time [s] from its epoch.

    By default for `REVOLUTIONS`, or for as long as the states of a file go on.
    Raises `ScenarioError` where the orbit or the sun is not known for so long.
    """
    period, days = period_of(known), known.orbit.days
    assert days is not None
    last = REVOLUTIONS * period if duration is None else duration
    if duration is None and isinstance(known.orbit.path, EphemerisTable):
        # Without states at all nothing is shortened, so that the refusal says when there are some.
        last = min(last, known.orbit.path.lasts(days) or last)
    count = max(2, math.ceil(_INSTANTS * last / period) + 1)
    if count > _MOST:
        raise ScenarioError(
            f"{known.origin}: {last:g} s are {last / period:.0f} revolutions, more than can be "
            "shown; give fewer hours"
        )
    orbit = covering(known.orbit, known.data, known.origin, last)
    dated = Table(dict(known.data), known.origin, "[orbit]", SPACECRAFT_TABLES["orbit"])
    check_epoch(dated, days, last, {SUNLIGHT: "the direction of the sun"})
    later = days + last / epoch.SECONDS_PER_DAY
    field = None
    if MAGNETIC_FIELD.holds(days) and MAGNETIC_FIELD.holds(later):
        field = igrf.at_year(epoch.decimal_year(moment_of(days)))
    task = OrbitTask(motion_of(orbit), jnp.asarray(days), field)
    light = Light(1361.0, None, Shadow(None, EQUATORIAL_RADIUS))
    times = np.linspace(0.0, last, count)
    padded = np.pad(times, (0, -count % _BLOCK), mode="edge").reshape(-1, _BLOCK)
    blocks = [jax.tree.map(np.asarray, _along(task, light, block)) for block in padded]
    found: Any = {
        key: None if field is None and key == "field" else _joined(blocks, key, count)
        for key in blocks[0]
    }
    return Course(known, times, **found, eclipses=eclipses(task, light, 0.0, last))


def _joined(blocks: Any, key: str, count: int) -> Floats:
    return np.concatenate([block[key] for block in blocks])[:count]


def _evaluate(task: OrbitTask, light: Light, times: jax.Array) -> dict[str, jax.Array | None]:
    """The series of a `Course` at some times (n,)."""
    along, nodes = evaluate(task, ExternalTorques(), False, times, light)
    assert along.sun is not None and along.light is not None
    r, v, _ = task.motion.at(times)
    normal = jnp.cross(r, v)
    normal = normal / jnp.linalg.norm(normal, axis=-1)[:, None]
    fixed = ground.earth_fixed(r, task.days + times / epoch.SECONDS_PER_DAY)
    latitude, longitude = ground.point_below(fixed)
    above = fixed - ground.place(latitude, longitude)
    return {
        "position": r,
        "velocity": v,
        "attitude": nodes.attitude.array,
        "rate": nodes.rate.array,
        "latitude": latitude,
        "longitude": longitude,
        "altitude": jnp.linalg.norm(above, axis=-1),
        "sun": along.sun.array,
        "light": along.light,
        "beta": jnp.arcsin(jnp.sum(normal * along.sun.array, axis=-1)),
        "field": None if nodes.field is None else nodes.field.array,
    }


_along = jax.jit(_evaluate, compiler_options=RUNS_ONCE)
