"""Keys of the tables of a plan."""

from __future__ import annotations

from jaxatt.problems.reading.schema import POSE_KEYS

TASK_KEYS = (
    "name",
    "mode",
    "start",
    "start_s",
    "end",
    "end_s",
    "duration_s",
    "step_s",
    "intervals",
    *POSE_KEYS,
    "frame",
    "rate",
    "rate_rad_s",
    "rate_deg_s",
    "attitude_tolerance_deg",
    "rate_tolerance_rad_s",
    "wheel_speed_rad_s",
    "load_W",
    "target_deg",
)
"""Keys of [[tasks]]."""

PLAN_KEYS = ("least_elevation_deg", "joint")
"""Keys of [plan]."""

HORIZON_KEYS = ("horizon_s", "step_s", "substeps")
"""Keys of [horizon] that a plan has."""

LONGEST_MANOEUVRE_S = 1e6
"""Longest task or manoeuvre: light and field are tabulated along all of it, for its fine flight."""
