"""Read the table [light]: sun and shadow along the orbit."""

from __future__ import annotations

from typing import Any

import numpy as np

from jaxatt.environment.eclipse import Shadow
from jaxatt.environment.light import Light
from jaxatt.environment.sun import ASTRONOMICAL_UNIT
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.orbit import LIGHT
from jaxatt.problems.scenario import Orbit

_SHADOW_KEYS = ("penumbra", "earth_radius_m", "sun_radius_m")


def read_light(data: Any, origin: str, orbit: Orbit | None) -> Light:
    """Read [light]; an empty table is the sun by date with the Earth's shadow.

    orbit : None in empty space, where there is no shadow and the sun must be given.
    Raises `ScenarioError`.
    """
    table = Table(data, origin, "[light]", LIGHT)
    shadow = None
    if table.choice("shadow", "none" if orbit is None else "conical") == "conical":
        if orbit is None:
            table.fail("shadow", "there is no [orbit]", 'add one, or write shadow = "none"')
        shadow = _shadow(table)
    else:
        for key in _SHADOW_KEYS:
            if key in table:
                table.fail(key, "there is no shadow", 'drop it, or write shadow = "conical"')
    return Light(table.number("irradiance_W_m2"), _sun(table, orbit), shadow)


def _sun(table: Table, orbit: Orbit | None) -> Any:
    if "sun_inertial" not in table:
        if orbit is None or orbit.days is None:
            table.fail(
                "sun_inertial",
                "missing, and there is no date to find the sun by",
                'add the direction to the sun, or epoch = "2026-06-21T12:00:00Z" to [orbit]',
            )
        if "sun_distance_m" in table:
            table.fail("sun_distance_m", "the date gives it", "drop it, or add sun_inertial")
        return None
    sun = table.vector("sun_inertial")
    length = float(np.linalg.norm(sun))
    if not length > 1e-12:
        table.fail("sun_inertial", "is no direction", "give the direction to the sun")
    return sun / length * table.number("sun_distance_m", ASTRONOMICAL_UNIT)


def _shadow(table: Table) -> Shadow:
    penumbra: float | None = None
    if table.data.get("penumbra") != "disk":
        if isinstance(table.data.get("penumbra"), str):
            table.fail("penumbra", "not one of the choices", 'give a number or "disk"')
        penumbra = table.number("penumbra")
    return Shadow(
        penumbra,
        table.number("earth_radius_m"),
        table.number("sun_radius_m"),
    )
