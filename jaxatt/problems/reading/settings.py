"""Read orbit, horizon and disturbances of a scenario."""

from __future__ import annotations

import math
from typing import Any

from jaxatt.problems.reading.dates import read_epoch
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.free_time import read_final_time
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.scenario import (
    Disturbances,
    Horizon,
    Orbit,
)

EARTH_RADIUS_KM = 6378.137  # equatorial, WGS 84
# Edge of the Earth's sphere of influence, rounded up: beyond it a distance was given in metres.
_LARGEST_AXIS_KM = 1e6
# The Earth's parameter is 3.986e14 m^3/s^2; far below it, km^3/s^2 were meant.
_SMALLEST_PARAMETER = 1e12

MOST_INTERVALS, MOST_SUBSTEPS, MOST_STEPS = 100_000, 10_000, 10_000_000
"""Control intervals of a horizon, and Runge-Kutta steps of an interval and of all of them."""


def read_orbit(data: Any, origin: str) -> Orbit:
    """Read the orbit, in metres and radians."""
    table = Table(data, origin, "[orbit]", SPACECRAFT_TABLES["orbit"])
    axis = table.number("semi_major_axis_km", above=0.0, example="6852.2")
    if axis > _LARGEST_AXIS_KM:
        table.fail("semi_major_axis_km", "farther out than the Moon", "give kilometres, not metres")
    eccentricity = table.number("eccentricity", at_least=0.0, example="0.002")
    if eccentricity >= 1.0:
        table.fail("eccentricity", "is no closed orbit", "give a number from 0 to less than 1")
    perigee = axis * (1.0 - eccentricity)
    if perigee <= EARTH_RADIUS_KM:
        table.fail(
            "semi_major_axis_km",
            f"the orbit passes below the Earth's surface (perigee {perigee:.6g} km from its "
            f"centre, radius {EARTH_RADIUS_KM} km)",
            "give the distance from the Earth's centre, not the altitude, in kilometres",
        )
    parameter = table.number("gravitational_parameter_m3_s2", 3.986e14, above=0.0)
    if parameter < _SMALLEST_PARAMETER:
        table.fail(
            "gravitational_parameter_m3_s2",
            "too small for the Earth",
            "give m^3/s^2, 3.986e14 for the Earth, not km^3/s^2",
        )
    inclination = table.number("inclination_deg", at_least=0.0, at_most=180.0, example="97.0")
    angle = {
        key: math.radians(table.number(f"{key}_deg", example="0.0"))
        for key in ("raan", "argument_of_periapsis", "true_anomaly")
    }
    return Orbit(
        semi_major_axis=axis * 1e3,
        eccentricity=eccentricity,
        inclination=math.radians(inclination),
        gravitational_parameter=parameter,
        days=read_epoch(table),
        **angle,
    )


_LARGEST_PHASE = 1000.0
"""[rad] of a sinusoidal torque in a control interval."""


def read_substeps(table: Table, intervals: int = 1) -> int | None:
    """Read the Runge-Kutta steps of an interval; None where they are chosen automatically."""
    if "substeps" not in table:
        return None
    return table.integer("substeps", at_most=min(MOST_SUBSTEPS, MOST_STEPS // intervals))


def read_horizon(data: Any, origin: str) -> Horizon:
    """Read the horizon: its length, fixed or free within limits, and its intervals."""
    table = Table(data, origin, "[horizon]", SPACECRAFT_TABLES["horizon"])
    free, shortest, longest = read_final_time(table)
    default = longest if math.isfinite(longest) else None
    duration = table.number("horizon_s", default, above=0.0, example="70.0")
    if not shortest <= duration <= longest:
        table.fail(
            "horizon_s",
            f"outside the final times allowed, {shortest:g} to {longest:g} seconds",
            "drop it, or change shortest_s or longest_s",
        )
    intervals = table.integer("intervals", at_most=MOST_INTERVALS)
    coast = table.integer("coast_intervals", 20, at_least=0, at_most=MOST_INTERVALS)
    return Horizon(
        duration=duration,
        intervals=intervals,
        coast_intervals=coast,
        substeps=read_substeps(table, intervals + coast),
        free=free,
        shortest=shortest,
        longest=longest,
    )


def read_disturbances(data: Any, origin: str, horizon: Horizon) -> Disturbances:
    """Read the disturbances; a negative sine amplitude is a phase of half a turn."""
    table = Table(data, origin, "[disturbances]", SPACECRAFT_TABLES["disturbances"])
    torque = table.number("sinusoidal_torque_Nm", 0.0)
    frequency = table.number("sinusoidal_frequency_rad_s", 1.0, at_least=0.0)
    step = (horizon.longest if horizon.free else horizon.duration) / horizon.intervals
    if torque and frequency * step > _LARGEST_PHASE:
        table.fail(
            "sinusoidal_frequency_rad_s",
            f"is {frequency * step:.3g} rad in a control interval of {step:g} s, more than steps "
            "can follow",
            "give a lower frequency or more intervals, or leave the torque out",
        )
    return Disturbances(table.flag("gravity_gradient"), torque, frequency)
