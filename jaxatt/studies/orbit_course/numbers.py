"""Numbers of an orbit: its elements, osculating and mean, eclipses, and the sun's height."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from jaxatt.environment.epoch import moment_text
from jaxatt.environment.orbit_data.element_set import ElementSet
from jaxatt.environment.orbit_data.j2 import OblatePath
from jaxatt.environment.orbit_data.mean_elements import mean_elements
from jaxatt.environment.orbit_data.oem import EphemerisTable
from jaxatt.environment.orbit_data.path import OrbitPath
from jaxatt.studies.orbit_course.course import Course, period_of

_DEGREES = ("inclination", "raan", "argument_of_periapsis", "true_anomaly")


def course_numbers(course: Course) -> dict[str, Any]:
    """Plain numbers, for `summary.json` and the table."""
    known = course.known
    orbit, path = known.orbit, known.orbit.path
    assert orbit.days is not None
    beta, low = np.degrees(course.beta), np.degrees(np.abs(course.latitude))
    return {
        "name": known.name,
        "title": known.title,
        "source": source_of(path),
        "epoch": moment_text(orbit.days),
        "duration_s": float(course.times[-1]),
        "frame": "mean equator and equinox of J2000 (EME2000)",
        "osculating_elements": {
            "semi_major_axis_km": 1e-3 * orbit.semi_major_axis,
            "eccentricity": orbit.eccentricity,
            **{f"{key}_deg": math.degrees(getattr(orbit, key)) for key in _DEGREES},
        },
        "mean_elements": _mean(path),
        "period_s": period_of(known),
        "altitude_km": [1e-3 * float(limit(course.altitude)) for limit in (np.min, np.max)],
        "highest_latitude_deg": float(low.max()),
        "eclipse_percent": 100.0 * course.dark,
        "eclipses": [
            {
                "penumbra_entry_s": each.penumbra_entry,
                "umbra_entry_s": each.umbra_entry,
                "umbra_exit_s": each.umbra_exit,
                "penumbra_exit_s": each.penumbra_exit,
            }
            for each in course.eclipses
        ],
        "longest_eclipse_s": _longest(course),
        "beta_deg": [float(beta[0]), float(beta[-1])],
        "field_uT": None
        if course.field is None
        else [1e6 * float(f(np.linalg.norm(course.field, axis=1))) for f in (np.min, np.max)],
        "off_by_km": 1e-3 * path.off_by(orbit.days) if isinstance(path, ElementSet) else None,
        "age_days": orbit.days - path.epoch if isinstance(path, ElementSet) else None,
        "notes": list(known.notes),
    }


def _longest(course: Course) -> float:
    whole = [each.penumbra_exit - each.penumbra_entry for each in course.eclipses]
    return max((length for length in whole if math.isfinite(length)), default=0.0)


def source_of(path: OrbitPath | None) -> str:
    """Where an orbit comes from, in words."""
    if isinstance(path, ElementSet):
        return f"SGP4 from elements of {path.title}, {moment_text(path.epoch)}"
    if isinstance(path, EphemerisTable):
        return f"ephemeris of {path.title} in {path.frame}"
    if isinstance(path, OblatePath):
        return "Keplerian elements with J2"
    return "Keplerian elements, two-body"


def _mean(path: OrbitPath | None) -> Mapping[str, Any] | None:
    """Mean elements, with the theory in which they are meant; None where there are none."""
    if isinstance(path, ElementSet):
        own = path.satrec
        return {
            "theory": "SGP4, in TEME, at the epoch of the elements",
            "mean_motion_rev_day": own.no_kozai * 1440.0 / (2.0 * math.pi),
            "eccentricity": own.ecco,
            "inclination_deg": math.degrees(own.inclo),
            "raan_deg": math.degrees(own.nodeo),
            "argument_of_periapsis_deg": math.degrees(own.argpo),
            "mean_anomaly_deg": math.degrees(own.mo),
        }
    if isinstance(path, OblatePath):
        found = mean_elements(path.r, path.v, path.pole, path.mu)
        return {
            "theory": "averages over a revolution under J2, at the start",
            "semi_major_axis_km": 1e-3 * float(found.semi_major_axis),
            "eccentricity": float(found.eccentricity),
            "inclination_deg": math.degrees(float(found.inclination)),
            "raan_deg": math.degrees(float(found.raan)),
            "argument_of_periapsis_deg": math.degrees(float(found.argument_of_perigee)),
            "true_anomaly_deg": math.degrees(float(found.true_anomaly)),
        }
    return None
