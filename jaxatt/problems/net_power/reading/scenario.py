"""Read the scenario of a manoeuvre, or of a plan of tasks, that is to earn energy."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.net_power.options import NetPowerOptions
from jaxatt.problems.net_power.orbit_frame import inertial_pose
from jaxatt.problems.net_power.plan.reading.plan import improved_jointly, plan_length, read_tasks
from jaxatt.problems.net_power.plan.reading.schema import HORIZON_KEYS, LONGEST_MANOEUVRE_S
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.reading.free_roll import check_free_roll, check_held_speeds
from jaxatt.problems.net_power.reading.objective import read_baseline, read_objective
from jaxatt.problems.net_power.reading.printed import PRINTED_ROWS, check_printed_totals
from jaxatt.problems.net_power.reading.satellite import read_satellite
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.aims import read_goal, read_state
from jaxatt.problems.reading.attitude_files import refuse_beside_file
from jaxatt.problems.reading.attitudes import attitude_given
from jaxatt.problems.reading.directions import Sky, sky_over
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.free_time import read_final_time
from jaxatt.problems.reading.heading import read_heading
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.problems.reading.settings import read_substeps
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.reading.wheel_speeds import read_wheel_speeds
from jaxatt.problems.scenario import Horizon, Orbit, Scenario
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import Spacecraft


def read_net_power(document: dict[str, Any], origin: str, folder: Path | None) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    return read_along(document, origin, folder, None)


def read_along(
    document: dict[str, Any], origin: str, folder: Path | None, moved: Orbit | None
) -> Scenario:
    """Read and check the scenario, along another orbit than the document's if one is given."""
    heading = read_heading(document, origin, NET_POWER_TABLES, printed_rows=PRINTED_ROWS)
    check_printed_totals(heading.printed, origin)
    notes: list[str] = []
    craft = read_vehicle(document["vehicle"], origin, folder, notes, magnetorquers_alone=True)
    orbit = moved
    if moved is None and "orbit" in document:
        orbit = read_orbit(document["orbit"], origin, folder, notes)
    plan = "tasks" in document
    if plan and "target" in document:
        raise ScenarioError(
            f"{origin}: [target]: not beside [[tasks]], which have their own; drop one of the two"
        )
    if "plan" in document and not plan:
        raise ScenarioError(f"{origin}: [plan]: there are no [[tasks]]; add some, or drop it")
    horizon = _plan_horizon(document, origin) if plan else _horizon(document, origin)
    _check_actuators(origin, craft, horizon)
    objective, wheel_power, cost, weights = read_objective(
        document.get("objective", {}), origin, craft, horizon.free
    )
    longest = horizon.longest if horizon.free else horizon.duration
    if orbit is not None:
        length = plan_length(document, origin, orbit.days) if plan else longest
        orbit = covering(orbit, document["orbit"], origin, length)
    satellite = read_satellite(document, origin, craft, orbit, wheel_power, longest)
    fixed = None if satellite.light.sun is None else np.asarray(satellite.light.sun)
    sky = sky_over(orbit, folder, "inertial", sun=fixed)
    initial, initial_frame = _initial(document["initial"], origin, craft, sky, notes)
    floor = _floor(document.get("limits", {}), origin, craft)
    tasks: tuple[Task, ...] = ()
    if plan:
        pose = inertial_pose(initial, initial_frame, satellite.orbit)
        tasks = read_tasks(document, origin, satellite, notes, sky, pose, floor)
        horizon = replace(
            horizon,
            duration=sum(task.duration for task in tasks),
            intervals=sum(task.intervals for task in tasks),
        )
    target, target_frame, speeds = None, "inertial", None
    if "target" in document:
        target, target_frame, speeds = _target(
            document["target"], origin, craft, sky, horizon, objective.terminal, notes
        )
        if target is not None and target.boresight is not None and speeds is not None:
            pose = inertial_pose(initial, initial_frame, satellite.orbit)
            check_held_speeds(document["target"], origin, satellite, pose, initial.omega_bw)
    return Scenario(
        **vars(heading),
        family="net-power",
        vehicle=craft,
        orbit=orbit,
        initial=initial,
        targets=() if target is None else (target,),
        horizon=horizon,
        objective=objective,
        notes=tuple(notes),
        document=document,
        origin=origin,
        folder=folder,
        options=NetPowerOptions(
            satellite=satellite,
            initial_frame=initial_frame,
            target_frame=target_frame,
            cost=cost,
            weights=weights,
            baseline=read_baseline(document.get("baseline"), origin, craft),
            wheel_speed_at_end=speeds,
            load=float(craft.loads.get("harvest", 0.0)),
            floor=floor,
            tasks=tasks,
            joint=plan and improved_jointly(document, origin),
        ),
    )


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


def _framed(table: Table, sky: Sky) -> Sky:
    """The sky with the frame that a table's attitude refers to."""
    frame = table.choice("frame")
    if frame == "orbit" and sky.motion is None:
        table.fail("frame", "there is no [orbit]", 'add one, or use "inertial"')
    return replace(sky, frame=frame)


def _initial(
    data: Any, origin: str, craft: Spacecraft, sky: Sky, notes: list[str]
) -> tuple[InitialState, str]:
    table = Table(data, origin, "[initial]", NET_POWER_TABLES["initial"])
    speeds = read_wheel_speeds(table, craft.wheels)
    if "aem_file" in table:
        refuse_beside_file(table, ("frame",))
    sky = _framed(table, sky)
    return InitialState(*read_state(table, notes, sky, 0.0), speeds), sky.frame


def _target(
    data: Any,
    origin: str,
    craft: Spacecraft,
    sky: Sky,
    horizon: Horizon,
    terminal: str,
    notes: list[str],
) -> tuple[Target | None, str, Floats | None]:
    """Read the target; an empty one leaves attitude and rate at the end free."""
    table = Table(data, origin, "[target]", NET_POWER_TABLES["target"])
    speeds = None
    for key in ("wheel_bias_rad_s", "wheel_bias_tolerance_rad_s"):
        if key in table:
            table.fail(
                key,
                "not where energy is weighed, whose answers take the speed of every wheel",
                "give wheel_speed_rad_s, or drop it",
            )
    if "wheel_speed_rad_s" in table:
        speeds = read_wheel_speeds(table, craft.wheels)
    sky = _framed(table, sky)
    if not attitude_given(table):
        for key in ("rate_rad_s", "rate"):
            if key in table:
                table.fail(key, "without an attitude", "give the attitude, too")
        return None, sky.frame, speeds
    tolerance = table.number("attitude_tolerance_deg")
    first = horizon.shortest if horizon.free else horizon.duration
    last = horizon.longest if horizon.free else horizon.duration
    if "align" in table and "constrain" not in table:
        check_free_roll(table, horizon, terminal)
    attitude, rate, boresight = read_goal(table, notes, sky, first, last)
    return (
        Target(
            q_ob=attitude,
            omega_ob=rate,
            boresight=boresight,
            attitude_tolerance=math.radians(tolerance),
            rate_tolerance=table.number("rate_tolerance_rad_s"),
        ),
        sky.frame,
        speeds,
    )


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
