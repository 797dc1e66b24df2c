"""Keys of the tables of a plan."""

from __future__ import annotations

from jaxatt.problems.net_power.plan.modes import HARVEST, MODES
from jaxatt.problems.reading.keys import Choice, Flag, Number, Numbers, TableKey, Text, Whole
from jaxatt.problems.reading.tables.attitude import (
    FORMS,
    FRAME,
    POSE_KEYS,
    RATE_KEYS,
    tolerances,
)
from jaxatt.problems.reading.tables.manoeuvre import HORIZON, MOST_INTERVALS, WHEEL_SPEEDS

LONGEST_MANOEUVRE_S = 1e6
"""Longest task or manoeuvre: light and field are tabulated along all of it, for its fine flight."""

_RATES = ("rate_rad_s", "rate_deg_s", "rate")
_STARTS, _ENDS = ("start", "start_s"), ("end", "end_s", "duration_s")

TASK_KEYS = TableKey(
    "tasks of a plan, one after the other",
    {
        "name": Text("name of the task", otherwise="its mode"),
        "mode": Choice(
            "earn energy on the way to the next task, take an image, point at a ground station, or "
            "wait",
            options=MODES,
            default=HARVEST,
        ),
        "start": Text("when it begins, UTC, as a time of day or with a date", otherwise="at once"),
        "start_s": Number("the same in seconds after the epoch"),
        "end": Text("when it ends"),
        "end_s": Number("the same in seconds after the epoch"),
        "duration_s": Number(
            "how long it takes", above=0.0, required=True, unless=("end", "end_s"), example="60.0"
        ),
        "step_s": Number("length of an interval", above=0.0, otherwise="that of [horizon]"),
        "intervals": Whole("number of intervals in place of that", at_most=MOST_INTERVALS),
        **POSE_KEYS,
        **FRAME,
        **RATE_KEYS,
        "rate_deg_s": Numbers("the same rate in degrees", size=3),
        **tolerances(0.1, 1e-4),
        **WHEEL_SPEEDS,
        "load_W": Number(
            "power of all else during the task", at_least=0.0, otherwise="that of [vehicle.loads]"
        ),
        "target_deg": Numbers(
            "geodetic latitude and longitude of a place that is to be in sight", size=2
        ),
    },
    many=True,
    named=True,
    apart=(*FORMS, _STARTS, _ENDS, ("intervals", "step_s"), _RATES),
)
"""Keys of [[tasks]]."""

PLAN_KEYS = TableKey(
    "plan of tasks",
    {
        "least_elevation_deg": Number(
            "elevation from which a satellite is in sight of a place",
            default=0.0,
            at_least=-90.0,
            at_most=90.0,
        ),
        "joint": Flag(
            "whether all tasks are improved together after they were solved in sequence",
            default=True,
        ),
    },
)
"""Keys of [plan]."""

HORIZON_KEYS = TableKey(
    "horizon of a plan",
    {
        "horizon_s": Number("length of the plan", above=0.0, otherwise="that of all tasks"),
        # Kristiansen (2023), table 5.3
        "step_s": Number("length of an interval of the [[tasks]]", default=2.0, above=0.0),
        "substeps": HORIZON["substeps"],
    },
)
"""Keys of [horizon] that a plan has."""
