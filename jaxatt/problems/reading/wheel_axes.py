"""Spin axes of wheels in a vehicle's table: as vectors, or as azimuths and elevations."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.problems.reading.fields import Table
from jaxatt.spacecraft.checks import Float64, finite_array

VECTORS, ANGLES = ("axes",), ("azimuth_deg", "elevation_deg")


def other_mounting(key: str) -> tuple[str, ...]:
    """Keys of [vehicle.wheels] that a new value under `key` replaces: the other form of axes."""
    if key in ANGLES:
        return VECTORS
    return ANGLES if key in VECTORS else ()


def read_wheel_axes(table: Table) -> Float64:
    """Read the axes (3, n) of [vehicle.wheels].

    As `axes`, one row a wheel, or as `azimuth_deg`, one number a wheel, from the body's x axis
    towards its y axis, and `elevation_deg`, one number for all or one a wheel, above the plane of
    the two: (cos e cos a, cos e sin a, sin e).  A pyramid of wheels is one elevation.
    """
    given = [key for key in ANGLES if key in table]
    if not given:
        return table.rows("axes")
    if "axes" in table:
        table.fail(given[0], "given beside axes", "keep one of the two and drop the other")
    azimuth = _angles(table, "azimuth_deg", "[45.0, 135.0, 225.0, 315.0]")
    elevation = _angles(table, "elevation_deg", "35.26")
    if azimuth.ndim != 1 or not azimuth.size:
        table.fail("azimuth_deg", "is no list of numbers", "give one azimuth for each wheel")
    if elevation.shape not in ((), azimuth.shape):
        table.fail(
            "elevation_deg",
            "does not fit the azimuths",
            f"give one number for all wheels, or {azimuth.size}, one for each",
        )
    a, e = np.radians(azimuth), np.radians(np.broadcast_to(elevation, azimuth.shape))
    return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def _angles(table: Table, key: str, example: str) -> Float64:
    given: Any = table.require(key)
    try:
        return finite_array(key, given)
    except ValueError:
        table.fail(key, "holds something that is no number", f"write {key} = {example}")
