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
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.reading.baseline import read_baseline
from jaxatt.problems.net_power.reading.free_roll import check_free_roll, check_held_speeds
from jaxatt.problems.net_power.reading.parts import read_parts
from jaxatt.problems.net_power.reading.satellite import read_satellite
from jaxatt.problems.net_power.reading.tables import NET_POWER_TABLES
from jaxatt.problems.reading.aims import read_goal, read_state
from jaxatt.problems.reading.attitude_files import refuse_beside_file
from jaxatt.problems.reading.attitudes import attitude_given
from jaxatt.problems.reading.directions import Sky, sky_over
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.orbit import covering, read_orbit
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
    notes: list[str] = []
    parts = read_parts(document, origin, folder, notes, faults)
    heading, craft, horizon, aim, floor = parts
    orbit = moved
    if moved is None and "orbit" in document:
        orbit = faults.of(read_orbit, document["orbit"], origin, folder, notes)
    plan = "tasks" in document
    orbit = faults.of(_covering, document, origin, orbit, horizon)
    longest = faults.of(_longest, horizon)
    satellite = faults.of(read_satellite, document, origin, craft, orbit, aim.wheel_power, longest)
    sky = faults.of(_sky, satellite, orbit, folder)
    start = faults.of(_initial, faults.table(document, "initial"), origin, craft, sky, notes)
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
