"""Read the tasks of a plan, and check that they follow one another and see their places."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from jaxatt.problems.net_power.manoeuvre import Satellite
from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.floor import check_floor
from jaxatt.problems.net_power.plan.reach import check_reach
from jaxatt.problems.net_power.plan.reading.order import check_jumps, check_times
from jaxatt.problems.net_power.plan.reading.schema import HORIZON_KEYS, PLAN_KEYS
from jaxatt.problems.net_power.plan.reading.tasks import Setting, read_task, task_table
from jaxatt.problems.net_power.plan.reading.times import read_span
from jaxatt.problems.net_power.plan.sight import check_sights
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.pose import Pose
from jaxatt.problems.reading.directions import Sky
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.orbit import has_date


def read_tasks(
    document: Mapping[str, Any],
    origin: str,
    satellite: Satellite,
    notes: list[str],
    sky: Sky,
    initial: Pose | None = None,
    floor: float = -math.inf,
) -> tuple[Task, ...]:
    """Read and check the tasks of a scenario's document.

    satellite : with its loads, and the orbit that it is on.  sky : what attitudes may be told by.
    initial : attitude and rate at the plan's start; None where they do not matter.
    floor : [J], least charge of the battery; -inf without.
    Raises `ScenarioError`, which names the task.
    """
    table = Table(document.get("horizon", {}), origin, "[horizon]", HORIZON_KEYS)
    horizon = table.number("horizon_s") if "horizon_s" in table else None
    step = table.number("step_s")
    given = document.get("tasks")
    if not isinstance(given, list) or not given:
        raise ScenarioError(
            f"{origin}: tasks: must be a list of tables; write [[tasks]] with double brackets"
        )
    flown = satellite.orbit
    dated = flown is not None and has_date(document.get("orbit", {}))
    days = float(flown.days) if flown is not None and dated else None
    setting = Setting(satellite.craft, step, sky, days)
    tables = [task_table(data, origin, index) for index, data in enumerate(given)]
    tasks: list[Task] = []
    before = 0.0
    for inner in tables:
        task = read_task(inner, before, setting, notes)
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
    least = least_elevation(document, origin)
    check_sights(tasks, None if days is None else flown, origin, least)
    check_reach(tasks, satellite.craft, initial, origin)
    check_floor(tasks, satellite, floor, origin, days)
    return tuple(tasks)


def plan_length(document: Mapping[str, Any], origin: str, days: float | None) -> float:
    """Time [s] at which the last task ends; 0 without a task.  days : epoch, or None."""
    end, given = 0.0, document.get("tasks")
    for index, data in enumerate(given if isinstance(given, list) else []):
        end = read_span(task_table(data, origin, index), end, days)[1]
    return end


def least_elevation(document: Mapping[str, Any], origin: str) -> float:
    """Read the elevation [rad] of the satellite that counts as in sight of a place."""
    table = _plan_table(document, origin)
    return math.radians(table.number("least_elevation_deg"))


def improved_jointly(document: Mapping[str, Any], origin: str) -> bool:
    """Read whether the tasks are improved together after they were solved in sequence."""
    return _plan_table(document, origin).flag("joint")


def _plan_table(document: Mapping[str, Any], origin: str) -> Table:
    return Table(document.get("plan", {}), origin, "[plan]", PLAN_KEYS)
