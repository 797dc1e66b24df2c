"""Read the parts of a net-power scenario that take no computing, and so no JAX."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

from jaxatt.problems.net_power.plan.reading.schema import HORIZON_KEYS, LONGEST_MANOEUVRE_S
from jaxatt.problems.net_power.reading.objective import EnergyObjective, read_objective
from jaxatt.problems.net_power.reading.printed import PRINTED_ROWS, check_printed_totals
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.free_time import read_final_time
from jaxatt.problems.reading.heading import Heading, read_heading
from jaxatt.problems.reading.settings import read_substeps
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.scenario_parts import Horizon
from jaxatt.spacecraft.parts.vehicle import Spacecraft


class Parts(NamedTuple):
    """What was read; floor : [J], least charge of the battery, -inf without."""

    heading: Heading
    craft: Spacecraft
    horizon: Horizon
    aim: EnergyObjective
    floor: float


def read_parts(
    document: dict[str, Any], origin: str, folder: Path | None, notes: list[str], faults: Faults
) -> Parts:
    """Read the parts; arguments as for `Family.read`, and notes, to which remarks are added."""
    heading = faults.of(read_heading, document, origin, NET_POWER_TABLES, printed_rows=PRINTED_ROWS)
    faults.of(check_printed_totals, heading.printed, origin)
    craft = faults.of(
        read_vehicle,
        faults.table(document, "vehicle"),
        origin,
        folder,
        notes,
        magnetorquers_alone=True,
    )
    faults.of(_check_tables, document, origin)
    horizon = faults.of(_plan_horizon if "tasks" in document else _horizon, document, origin)
    faults.of(_check_actuators, origin, craft, horizon)
    aim = faults.of(read_objective, document.get("objective", {}), origin, craft, horizon.free)
    floor = faults.of(_floor, document.get("limits", {}), origin, craft)
    return Parts(heading, craft, horizon, aim, floor)


def _check_tables(document: dict[str, Any], origin: str) -> None:
    if "tasks" in document and "target" in document:
        raise ScenarioError(
            f"{origin}: [target]: not beside [[tasks]], which have their own; drop one of the two"
        )
    if "plan" in document and "tasks" not in document:
        raise ScenarioError(f"{origin}: [plan]: there are no [[tasks]]; add some, or drop it")


def _check_actuators(origin: str, craft: Spacecraft, horizon: Horizon) -> None:
    if craft.thrusters.count:
        raise ScenarioError(
            f"{origin}: [vehicle.thrusters]: their propellant is not counted in watts; drop them, "
            "or use an objective for thrusters"
        )
    if horizon.free and craft.wheels.count:
        raise ScenarioError(
            f'{origin}: [horizon] final_time = "free": only for satellites with magnetorquers '
            'alone; give horizon_s and final_time = "fixed"'
        )
    if not horizon.free and not craft.wheels.count:
        raise ScenarioError(
            f'{origin}: [horizon] final_time: magnetorquers alone need it "free"; give shortest_s '
            "and longest_s"
        )


def _horizon(document: dict[str, Any], origin: str) -> Horizon:
    """Read the horizon of a single manoeuvre."""
    if "horizon" not in document:
        raise ScenarioError(f"{origin}: [horizon] is missing; add it with horizon_s and intervals")
    table = Table(document["horizon"], origin, "[horizon]", NET_POWER_TABLES["horizon"])
    free, shortest, longest = read_final_time(table)
    if "coast_intervals" in table:
        table.fail("coast_intervals", "nothing follows the manoeuvre", "drop it")
    if free and not math.isfinite(longest):
        table.fail("longest_s", "missing", "give the longest final time, e.g. longest_s = 6000.0")
    default = longest if free else None
    duration = table.number("horizon_s", default)
    if max(duration, longest if free else 0.0) > LONGEST_MANOEUVRE_S:
        key = "longest_s" if free else "horizon_s"
        table.fail(
            key, f"must be at most {LONGEST_MANOEUVRE_S:g}", "give a smaller number in seconds"
        )
    intervals = table.integer("intervals")
    return Horizon(
        duration=duration,
        intervals=intervals,
        coast_intervals=0,
        substeps=read_substeps(table, intervals),
        free=free,
        shortest=shortest,
        longest=longest,
    )


def _plan_horizon(document: dict[str, Any], origin: str) -> Horizon:
    """Read the horizon of a plan, before its tasks say how long it is."""
    table = Table(document.get("horizon", {}), origin, "[horizon]", NET_POWER_TABLES["horizon"])
    for key in table.data:
        if key not in HORIZON_KEYS:
            table.fail(key, "the tasks have their own lengths", "drop it, or give step_s")
    return Horizon(duration=0.0, intervals=0, coast_intervals=0, substeps=read_substeps(table))


def _floor(data: Any, origin: str, craft: Spacecraft) -> float:
    """Read the least charge of the battery [J]; -inf without."""
    table = Table(data, origin, "[limits]", NET_POWER_TABLES["limits"])
    if "least_charge_percent" not in table:
        return -math.inf
    if craft.battery is None:
        table.fail("least_charge_percent", "the vehicle has no battery", "add [vehicle.battery]")
    percent = table.number("least_charge_percent")
    floor = 0.01 * percent * float(craft.battery.capacity)
    if floor > float(craft.battery.charge):
        table.fail(
            "least_charge_percent",
            "the battery starts below it",
            "start with more charge, or lower the floor",
        )
    return floor
