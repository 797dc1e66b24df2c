"""Read a plan: the tables [plan] and [[tasks]]."""

from __future__ import annotations

import math
from typing import Any

from jaxatt.problems.net_power.plan.reading.order import check_jumps, check_times
from jaxatt.problems.net_power.plan.reading.schema import PLAN_KEYS
from jaxatt.problems.net_power.plan.reading.tasks import OrbitFrame, read_task, task_table
from jaxatt.problems.net_power.plan.reading.times import clock_text
from jaxatt.problems.net_power.plan.task import Plan, Pose
from jaxatt.problems.reading.fields import ScenarioError, Table

_STEP = 2.0  # [s], of Kristiansen (2023), table 5.3
_JOULE = 3600.0


def read_plan(
    document: dict[str, Any],
    origin: str,
    *,
    initial: Pose | None = None,
    days: float | None = None,
    orbit: OrbitFrame | None = None,
    capacity: float | None = None,
    notes: list[str],
) -> Plan:
    """Read and check the plan of a scenario's document.

    initial : attitude and rate at its start.  days : epoch, days since J2000; None without.
    orbit : the orbit frame over time; None without an orbit.
    capacity : [J], of the battery; None without one.
    Raises `ScenarioError`, which names the task.
    """
    table = Table(document.get("plan", {}), origin, "[plan]", PLAN_KEYS)
    horizon = table.number("horizon_s", above=0.0) if "horizon_s" in table else None
    step = table.number("step_s", _STEP, above=0.0)
    given = document.get("tasks")
    if not isinstance(given, list) or not given:
        raise ScenarioError(
            f"{origin}: tasks: must be a list of tables; write [[tasks]] with double brackets"
        )
    tables = [task_table(data, origin, index) for index, data in enumerate(given)]
    tasks, before = [], 0.0
    for inner in tables:
        task = read_task(inner, before, step, days, orbit, notes)
        check_times(inner, task, before, horizon, days)
        tasks.append(task)
        before = task.end
    if horizon is not None and before < horizon - 1e-6:
        table.fail(
            "horizon_s",
            f"the last task ends at {clock_text(before, days)}, {horizon - before:g} s before it",
            'add a task of mode "harvest" or "idle", or drop the horizon',
        )
    check_jumps(tables, tasks, initial)
    return Plan(
        tuple(tasks),
        least_elevation=math.radians(
            table.number("least_elevation_deg", 0.0, at_least=-90.0, at_most=90.0)
        ),
        least_charge=_least_charge(table, capacity),
        joint=table.flag("joint", True),
    )


def _least_charge(table: Table, capacity: float | None) -> float:
    """Read the floor of the battery's charge [J]; -inf without."""
    keys = [key for key in ("least_charge_percent", "least_charge_Wh") if key in table]
    if not keys:
        return -math.inf
    if len(keys) > 1:
        table.fail(keys[1], f"given beside {keys[0]}", "keep one of the two")
    if capacity is None:
        table.fail(keys[0], "the vehicle has no battery", "add [vehicle.battery], or drop it")
    if keys[0] == "least_charge_percent":
        return capacity * table.number(keys[0], at_least=0.0, at_most=100.0) / 100.0
    floor = _JOULE * table.number(keys[0], at_least=0.0)
    if floor > capacity:
        table.fail(
            keys[0], f"more than the capacity of {capacity / _JOULE:g} Wh", "give a lower floor"
        )
    return floor
