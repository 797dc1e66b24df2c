"""Read the scenario of a manoeuvre, or of a plan of tasks, that is to earn energy."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from jaxatt.problems.manoeuvre import InitialState, Target
from jaxatt.problems.net_power.manoeuvre import Satellite
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
from jaxatt.problems.reading.faults import Faults
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


def read_net_power(
    document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    return read_along(document, origin, folder, None, faults)


def read_along(
    document: dict[str, Any],
    origin: str,
    folder: Path | None,
    moved: Orbit | None,
    faults: Faults,
) -> Scenario:
    """Read and check the scenario, along another orbit than the document's if one is given."""
    heading = faults.of(read_heading, document, origin, NET_POWER_TABLES, printed_rows=PRINTED_ROWS)
    faults.of(check_printed_totals, heading.printed, origin)
    notes: list[str] = []
    craft = faults.of(
        read_vehicle,
        faults.table(document, "vehicle"),
        origin,
        folder,
        notes,
        magnetorquers_alone=True,
    )
    orbit = moved
    if moved is None and "orbit" in document:
        orbit = faults.of(read_orbit, document["orbit"], origin, folder, notes)
    plan = "tasks" in document
    faults.of(_check_tables, document, origin)
    horizon = faults.of(_plan_horizon if plan else _horizon, document, origin)
    faults.of(_check_actuators, origin, craft, horizon)
    aim = faults.of(read_objective, document.get("objective", {}), origin, craft, horizon.free)
    orbit = faults.of(_covering, document, origin, orbit, horizon)
    longest = faults.of(_longest, horizon)
    satellite = faults.of(read_satellite, document, origin, craft, orbit, aim.wheel_power, longest)
    sky = faults.of(_sky, satellite, orbit, folder)
    start = faults.of(_initial, faults.table(document, "initial"), origin, craft, sky, notes)
    floor = faults.of(_floor, document.get("limits", {}), origin, craft)
    tasks: tuple[Task, ...] = ()
    if plan:
        pose = faults.of(inertial_pose, start.state, start.frame, satellite.orbit)
        tasks = faults.of(read_tasks, document, origin, satellite, notes, sky, pose, floor)
        horizon = faults.of(_of_tasks, horizon, tasks)
    end = _End()
    if "target" in document:
        end = faults.of(
            _target, document["target"], origin, craft, sky, horizon, aim.objective.terminal, notes
        )
    baseline = faults.of(read_baseline, document.get("baseline"), origin, craft)
    joint = faults.of(_joint, document, origin)
    faults.refuse()
    if end.target is not None and end.target.boresight is not None and end.speeds is not None:
        pose = inertial_pose(start.state, start.frame, satellite.orbit)
        check_held_speeds(document["target"], origin, satellite, pose, start.state.omega_bw)
    return Scenario(
        **vars(heading),
        family="net-power",
        vehicle=craft,
        orbit=orbit,
        initial=start.state,
        targets=() if end.target is None else (end.target,),
        horizon=horizon,
        objective=aim.objective,
        notes=tuple(notes),
        document=document,
        origin=origin,
        folder=folder,
        options=NetPowerOptions(
            satellite=satellite,
            initial_frame=start.frame,
            target_frame=end.frame,
            cost=aim.cost,
            weights=aim.weights,
            baseline=baseline,
            wheel_speed_at_end=end.speeds,
            load=float(craft.loads.get("harvest", 0.0)),
            floor=floor,
            tasks=tasks,
            joint=joint,
        ),
    )


class _Beginning(NamedTuple):
    """The initial state, and the frame that it refers to."""

    state: InitialState
    frame: str


class _End(NamedTuple):
    """The target, if there is one, the frame that it refers to, and wheel speeds (n,) [rad/s]."""

    target: Target | None = None
    frame: str = "inertial"
    speeds: Floats | None = None


def _check_tables(document: dict[str, Any], origin: str) -> None:
    if "tasks" in document and "target" in document:
        raise ScenarioError(
            f"{origin}: [target]: not beside [[tasks]], which have their own; drop one of the two"
        )
    if "plan" in document and "tasks" not in document:
        raise ScenarioError(f"{origin}: [plan]: there are no [[tasks]]; add some, or drop it")


def _longest(horizon: Horizon) -> float:
    return horizon.longest if horizon.free else horizon.duration


def _covering(
    document: dict[str, Any], origin: str, orbit: Orbit | None, horizon: Horizon
) -> Orbit | None:
    if orbit is None:
        return None
    plan = "tasks" in document
    length = plan_length(document, origin, orbit.days) if plan else _longest(horizon)
    return covering(orbit, document["orbit"], origin, length)


def _sky(satellite: Satellite, orbit: Orbit | None, folder: Path | None) -> Sky:
    fixed = None if satellite.light.sun is None else np.asarray(satellite.light.sun)
    return sky_over(orbit, folder, "inertial", sun=fixed)


def _of_tasks(horizon: Horizon, tasks: tuple[Task, ...]) -> Horizon:
    return replace(
        horizon,
        duration=sum(task.duration for task in tasks),
        intervals=sum(task.intervals for task in tasks),
    )


def _joint(document: dict[str, Any], origin: str) -> bool:
    return "tasks" in document and improved_jointly(document, origin)


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


def _initial(data: Any, origin: str, craft: Spacecraft, sky: Sky, notes: list[str]) -> _Beginning:
    table = Table(data, origin, "[initial]", NET_POWER_TABLES["initial"])
    speeds = read_wheel_speeds(table, craft.wheels)
    if "aem_file" in table:
        refuse_beside_file(table, ("frame",))
    sky = _framed(table, sky)
    return _Beginning(InitialState(*read_state(table, notes, sky, 0.0), speeds), sky.frame)


def _target(
    data: Any,
    origin: str,
    craft: Spacecraft,
    sky: Sky,
    horizon: Horizon,
    terminal: str,
    notes: list[str],
) -> _End:
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
        return _End(None, sky.frame, speeds)
    tolerance = table.number("attitude_tolerance_deg")
    first = horizon.shortest if horizon.free else horizon.duration
    last = horizon.longest if horizon.free else horizon.duration
    if "align" in table and "constrain" not in table:
        check_free_roll(table, horizon, terminal)
    attitude, rate, boresight = read_goal(table, notes, sky, first, last)
    target = Target(
        q_ob=attitude,
        omega_ob=rate,
        boresight=boresight,
        attitude_tolerance=math.radians(tolerance),
        rate_tolerance=table.number("rate_tolerance_rad_s"),
    )
    return _End(target, sky.frame, speeds)


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
