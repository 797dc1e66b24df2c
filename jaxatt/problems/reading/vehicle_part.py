"""What readers of a vehicle's parts share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.vehicle import VEHICLE_PARTS
from jaxatt.spacecraft.checks import FieldError

Part = TypeVar("Part")

TOML_NAMES = {
    "inertia": "inertia_kgm2",
    "torque_limit": "torque_limit_Nm",
    "speed_limit": "speed_limit_rad_s",
    "coulomb": "coulomb_friction_Nm",
    "viscous": "viscous_friction_Nms",
    "full_torque_speed": "full_torque_speed_rad_s",
    "no_torque_speed": "no_torque_speed_rad_s",
    "dipole_limit": "dipole_limit_Am2",
    "full_power": "full_power_W",
    "coil_area": "coil_area_m2",
    "resistance": "resistance_ohm",
    "minimum_on_time": "minimum_on_time_s",
    "minimum_impulse": "minimum_impulse_Nms",
    "area": "area_m2",
}
"""Names in TOML of the constructors' fields, where they differ."""


def part(table: Table, name: str) -> Table:
    """Return the table of a part: [vehicle.wheels], or [wheels] in a vehicle's own file."""
    label = f"[vehicle.{name}]" if table.label else f"[{name}]"
    return Table(table.data[name], table.origin, label, VEHICLE_PARTS[name])


def checked(table: Table, build: Callable[[], Part]) -> Part:
    """Return what `build` makes; where it refuses a field, fail with the key of the table."""
    try:
        return build()
    except FieldError as error:
        table.fail(TOML_NAMES.get(error.field, error.field), *error.problem_and_mend)
