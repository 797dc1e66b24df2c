"""Read the solar panels, the battery and the loads of a vehicle."""

from __future__ import annotations

import math

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.vehicle import LOADS
from jaxatt.problems.reading.vehicle_part import checked, part
from jaxatt.spacecraft.parts.battery import Battery, battery
from jaxatt.spacecraft.parts.panels import SolarPanels, solar_panels

_HOUR = 3600.0


def read_panels(vehicle: Table) -> SolarPanels | None:
    """Read [vehicle.panels]; None without it."""
    if "panels" not in vehicle:
        return None
    table = part(vehicle, "panels")
    normals = table.rows("normals")
    area = table.require("area_m2")
    efficiency = table.require("efficiency")
    shades = table.integer("shades") - 1 if "shades" in table else None
    incidence = table.choice("incidence")
    return checked(table, lambda: solar_panels(normals, area, efficiency, shades, incidence))


def read_battery(vehicle: Table) -> Battery | None:
    """Read [vehicle.battery]; None without it.

    A charge that is not given is full, or nothing where the capacity is not known either.
    """
    if "battery" not in vehicle:
        return None
    table = part(vehicle, "battery")
    known = _energy(table, "capacity")
    capacity = math.inf if known is None else known
    charge = _energy(table, "charge")
    if "charge_percent" in table:
        if capacity == math.inf:
            table.fail("charge_percent", "of an unknown capacity", "add capacity_Wh")
        percent = table.number("charge_percent")
        if percent > 100.0:
            table.fail(
                "charge_percent",
                "starts above the capacity of the battery",
                "give a number from 0 to 100",
            )
        charge = 0.01 * percent * capacity
    if charge is not None and charge > capacity and "charge_percent" not in table:
        key = "charge_Wh" if "charge_Wh" in table else "charge_J"
        table.fail(
            key,
            f"starts above the capacity of the battery, {_shown(capacity, key)}",
            "give less, or a larger capacity; check the units of both",
        )
    return checked(
        table,
        lambda: battery(
            capacity,
            charge,
            table.data.get("input_efficiency", 1.0),
            table.data.get("output_efficiency", 1.0),
        ),
    )


def read_loads(vehicle: Table) -> dict[str, float]:
    """Read [vehicle.loads]: power [W] by mode of operation; empty without it."""
    if "loads" not in vehicle:
        return {}
    table = part(vehicle, "loads")
    return {key.removesuffix("_W"): table.number(key) for key in LOADS if key in table}


def _energy(table: Table, name: str) -> float | None:
    if f"{name}_Wh" in table:
        return _HOUR * table.number(f"{name}_Wh")
    if f"{name}_J" in table:
        return table.number(f"{name}_J")
    return None


def _shown(energy: float, key: str) -> str:
    return f"{energy / _HOUR:g} Wh" if key.endswith("_Wh") else f"{energy:g} J"
