"""Read the tasks of a plan, one table each."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jaxatt.problems.along_orbit import to_inertial
from jaxatt.problems.net_power.plan.modes import COMMUNICATE, HARVEST, IDLE, IMAGE
from jaxatt.problems.net_power.plan.reading.schema import TASK_KEYS
from jaxatt.problems.net_power.plan.reading.times import read_span
from jaxatt.problems.net_power.plan.task import Site, Task
from jaxatt.problems.net_power.pose import Pose, angle_between
from jaxatt.problems.reading.aims import read_state
from jaxatt.problems.reading.attitudes import attitude_given
from jaxatt.problems.reading.directions import Sky
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.tables.attitude import AIM_KEYS, POSE_KEYS
from jaxatt.problems.reading.tables.manoeuvre import MOST_INTERVALS
from jaxatt.problems.reading.wheel_speeds import read_wheel_speeds
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft import Spacecraft

_WHOLE = 1e-6
_RATES = ("rate_rad_s", "rate_deg_s")
_HELD = ("frame", "rate", *_RATES, *POSE_KEYS)
_BEGINS = ("attitude_tolerance_deg", "rate_tolerance_rad_s", "wheel_speed_rad_s")
_AWAY = math.radians(0.1)
"""By which directions may leave a task that holds its attitude before it is told."""


def task_table(data: Any, origin: str, index: int) -> Table:
    """Table of the task with this index, whose label has its number and name."""
    name = data.get("name") if isinstance(data, dict) else None
    named = f' "{name}"' if isinstance(name, str) else ""
    return Table(data, origin, f"[[tasks]] no. {index + 1}{named}", TASK_KEYS)


@dataclass(frozen=True)
class Setting:
    """What the tasks of a plan are read against.

    craft : whose loads and wheels count.  step : [s], length of an interval unless a task says
    otherwise.  sky : what attitudes may be told by, in inertial axes.
    days : epoch of the clock, days since J2000; None without.
    """

    craft: Spacecraft
    step: float
    sky: Sky
    days: float | None = None


def read_task(table: Table, before: float, setting: Setting, notes: list[str]) -> Task:
    """Read one task; before : [s], end of the task before.  Raises `ScenarioError`."""
    mode = table.choice("mode")
    start, end = read_span(table, before, setting.days)
    craft = setting.craft
    return Task(
        name=table.text("name", mode),
        mode=mode,
        start=start,
        duration=end - start,
        intervals=_intervals(table, end - start, setting.step, notes),
        pose=_pose(table, mode, start, end, setting.sky, notes),
        attitude_tolerance=math.radians(table.number("attitude_tolerance_deg")),
        rate_tolerance=table.number("rate_tolerance_rad_s"),
        omega_bw=_speeds(table, craft),
        load=table.number("load_W", float(craft.loads.get(mode, 0.0))),
        site=_site(table, mode),
    )


def _intervals(table: Table, duration: float, step: float, notes: list[str]) -> int:
    if "intervals" in table:
        return table.integer("intervals")
    wanted = duration / table.number("step_s", step)
    if wanted > MOST_INTERVALS:
        table.fail(
            "step_s",
            f"the task takes {duration:g} s, more than {MOST_INTERVALS} intervals",
            "give longer intervals, or a shorter task",
        )
    count = max(1, math.ceil(wanted - _WHOLE))
    if abs(wanted - count) > _WHOLE * count:
        notes.append(f"{table.label}: intervals of {duration / count:.6g} s fit its duration")
    return count


def _pose(
    table: Table, mode: str, start: float, end: float, sky: Sky, notes: list[str]
) -> Pose | None:
    """Read attitude and rate in inertial axes with which a task begins."""
    if mode == HARVEST:
        for key in (*_HELD, *_BEGINS, "target_deg"):
            if key in table:
                table.fail(
                    key,
                    "a harvest ends in the attitude and rate of the task after it",
                    f'drop it, or add a task of mode "{IDLE}" with it behind the harvest',
                )
        return None
    if not attitude_given(table):
        if mode != IDLE:
            table.require("attitude_quaternion")
        for key in _HELD:
            if key in table:
                table.fail(key, "given without an attitude", "add attitude_quaternion, or drop it")
        return None
    frame = table.choice("frame")
    if frame == "orbit" and sky.motion is None:
        table.fail("frame", "there is no orbit", 'add [orbit], or use frame = "inertial"')
    sky = replace(sky, frame=frame)
    if not any(key in table for key in AIM_KEYS):
        return _pose_at(table, mode, sky, start, notes)
    middle = 0.5 * (start + end)
    # The ends first: a place that sets is refused before anything is told of it.
    asked = [_pose_at(table, mode, sky, time, []) for time in (start, end)]
    pose = _pose_at(table, mode, sky, middle, notes)
    held = [pose.after(time - middle) for time in (start, end)]
    away = max(angle_between(a.q_ib, b.q_ib) for a, b in zip(asked, held, strict=True))
    if away > _AWAY:
        notes.append(
            f"{table.label} points as asked in its middle; at its ends its directions are up to "
            f"{math.degrees(away):.3g} deg away"
        )
    return held[0]


def _pose_at(table: Table, mode: str, sky: Sky, time: float, notes: list[str]) -> Pose:
    """Read inertial attitude and rate at a time [s]."""
    q, rate = read_state(table, notes, sky, time)
    if "rate" not in table:
        rate = _rate(table, mode)
    motion = sky.motion if sky.frame == "orbit" else None
    found = to_inertial(motion, np.array([time]), q[None], rate[None])
    return Pose(found[0][0], found[1][0])


def _rate(table: Table, mode: str) -> Floats:
    """Read the rate [rad/s]; zero without."""
    key = "rate_deg_s" if "rate_deg_s" in table else "rate_rad_s"
    rate = table.vector(key)
    if mode in (COMMUNICATE, IDLE) and rate.any():
        table.fail(key, f"a task of this mode holds its attitude, only {IMAGE} turns", "drop it")
    return np.deg2rad(rate) if key == "rate_deg_s" else rate


def _speeds(table: Table, craft: Spacecraft) -> Floats | None:
    if "wheel_speed_rad_s" not in table:
        return None
    return read_wheel_speeds(table, craft.wheels)


def _site(table: Table, mode: str) -> Site | None:
    """Read the place that must be in sight: latitude and longitude."""
    if "target_deg" not in table:
        return None
    if mode not in (IMAGE, COMMUNICATE):
        table.fail("target_deg", "a task of this mode looks at nothing", "drop it")
    latitude, longitude = table.vector("target_deg")
    if abs(latitude) > 90.0 or abs(longitude) > 360.0:
        table.fail(
            "target_deg",
            "is no place on the Earth",
            "give the geodetic latitude (-90 to 90), then the longitude east, in degrees",
        )
    return Site(math.radians(latitude), math.radians(longitude))
