"""Tables and keys that are allowed in a flight's file."""

from __future__ import annotations

from collections.abc import Mapping

from jaxatt.problems.reading.schema import FILE_KEYS, POSE_KEYS, SPACECRAFT_TABLES

FLIGHT_TABLES: Mapping[str, tuple[str, ...]] = {
    "vehicle": SPACECRAFT_TABLES["vehicle"],
    "orbit": SPACECRAFT_TABLES["orbit"],
    "environment": (
        "epoch",
        "gravity_gradient",
        "sinusoidal_torque_Nm",
        "sinusoidal_frequency_rad_s",
        "sun_direction",
        "drag",
        "solar_pressure",
        "residual_dipole_Am2",
        "eddy_coefficient",
    ),
    "initial": SPACECRAFT_TABLES["initial"],
    "reference": (
        *POSE_KEYS,
        "rate_rad_s",
        "rate",
        "from_s",
        "attitude_held",
        "manoeuvre",
        *FILE_KEYS,
    ),
    "simulation": ("duration_s", "sampling_s", "step_s", "hold", "records", "tumbling_rad_s"),
    "settling": ("signal", "band_deg", "band_rad_s", "since_s"),
    "noise": ("rate_rad_s", "wheel_speed_rad_s"),
    "dumping": ("gain_1_s", "form", "wheel_speed_rad_s"),
    "laws": (),
    "campaign": (
        "runs",
        "seed",
        "attitude_deg",
        "rate_rad_s",
        "inertia_percent",
        "misalignment_deg",
        "gain_percent",
    ),
    "printed": (),
}

PRINTED_FIGURES: Mapping[str, int] = {
    "settling_s": 3,
    "settling_worst_s": 1,
    "rms_deg": 3,
    "rms_rad_s": 3,
    "peak_Nm": 3,
    "settling_limit_s": 1,
    "integral_Nms": 1,
}
"""Figures of [printed.LAW] that are compared, and how many numbers each has."""

DRAG_KEYS = ("density_kg_m3", "area_m2", "coefficient", "lever_m", "corotating")
SOLAR_KEYS = ("irradiance_W_m2", "light_speed_m_s", "area_m2", "reflectance", "lever_m")

_PD = ("proportional_1_s2", "derivative_1_s")
LAW_KEYS: Mapping[str, tuple[str, ...]] = {
    "pd": _PD,
    "tracking": _PD,
    "sliding-mode": ("surface", "slope_1_s", "gain_1_s2"),
    "super-twisting": ("surface", "slope_1_s", "first_gain", "second_gain", "beta"),
    "min-norm": (*_PD, "coupling_1_s", "inverse_inertia"),
    "gain-scheduled": (*_PD, "coupling_1_s", "threshold_Nm", "inverse_inertia"),
    "latched": (*_PD, "coupling_1_s", "inverse_inertia"),
    "krstic-tsiotras": ("first_gain_1_s", "second_gain_1_s", "factor"),
}
