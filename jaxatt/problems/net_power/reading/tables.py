"""TOML tables of a scenario of net power, with the keys that each may hold."""

from __future__ import annotations

from collections.abc import Mapping

from jaxatt.problems.net_power.plan.reading.schema import PLAN_KEYS, TASK_KEYS
from jaxatt.problems.reading.schema import LIGHT_KEYS, SPACECRAFT_TABLES

NET_POWER_TABLES: Mapping[str, tuple[str, ...]] = {
    "vehicle": SPACECRAFT_TABLES["vehicle"],
    "orbit": SPACECRAFT_TABLES["orbit"],
    "light": LIGHT_KEYS,
    "initial": (*SPACECRAFT_TABLES["initial"], "frame"),
    "target": (*SPACECRAFT_TABLES["target"], "frame", "wheel_speed_rad_s"),
    "plan": PLAN_KEYS,
    "tasks": TASK_KEYS,
    "horizon": (*SPACECRAFT_TABLES["horizon"], "step_s"),
    "disturbances": ("gravity_gradient", "residual_dipole_Am2", "eddy_coefficient"),
    "magnetorquing": ("mode", "gain", "wheel_speed_rad_s"),
    "objective": (
        "kind",
        "terminal",
        "cost",
        "wheel_power",
        "attitude_weight_J",
        "rate_weight_J_s2",
        "attitude_weight_W",
        "rate_weight_W_s2",
        "time_weight_W_s",
    ),
    "baseline": ("attitude_gain_Nm", "rate_gain_Nm_s", "turn_back_s", "hold_s", "nearest_to"),
    "limits": ("least_charge_percent",),
    "solver": SPACECRAFT_TABLES["solver"],
    "printed": (),
}
"""[light] and [vehicle] are read by `problems.reading`, the rest by this family."""
