"""Tables and keys that are allowed in a scenario file, and suggestions for misspelt ones."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

ATTITUDE_KEYS = (
    "attitude_deg",
    "attitude_quaternion",
    "attitude_mrp",
    "axis",
    "angle_deg",
    "angle_rad",
)
"""Three angles, a quaternion, modified Rodrigues parameters, or an axis with an angle."""

AIM_KEYS = ("align", "constrain")
"""A body axis that points along a direction, and one that is turned towards another."""
TOWARD_KEYS = (
    "toward",
    "direction_inertial",
    "direction_orbit",
    "right_ascension_deg",
    "declination_deg",
    "latitude_deg",
    "longitude_deg",
    "height_m",
    "satellite",
)
"""A direction in words, by components, or by angles."""
DIRECTION_KEYS = ("body", *TOWARD_KEYS)

POSE_KEYS = (*ATTITUDE_KEYS, *AIM_KEYS)
FILE_KEYS = ("aem_file", "at")
"""A CCSDS attitude file, and the moment (UTC) in it at which the scenario starts."""
_TARGET = (
    *POSE_KEYS,
    "rate_rad_s",
    "rate",
    "attitude_tolerance_deg",
    "rate_tolerance_rad_s",
    "wheel_bias_rad_s",
    "wheel_bias_tolerance_rad_s",
)
_HORIZON = (
    "horizon_s",
    "intervals",
    "coast_intervals",
    "substeps",
    "final_time",
    "shortest_s",
    "longest_s",
)
_WINDOW = ("first_interval", "last_interval", "start_s", "end_s", "weight", "forbidden")
_CONE = ("name", "boresight", "half_angle_deg", *TOWARD_KEYS)
_SOLVER = ("starts", "seed")
_TOP = ("name", "title", "source", "system")

WHEEL_KEYS = (
    "axes",
    "azimuth_deg",
    "elevation_deg",
    "inertia_kgm2",
    "torque_limit_Nm",
    "speed_limit_rad_s",
    "efficiency",
    "regeneration",
    "names",
    "failed",
    "coulomb_friction_Nm",
    "viscous_friction_Nms",
    "full_torque_speed_rad_s",
    "no_torque_speed_rad_s",
    "avoid",
)
AVOID_KEYS = ("from_rad_s", "to_rad_s", "leave_within_s")
"""Edges of a band of speeds that wheels avoid, and how soon they must leave it."""
MAGNETORQUER_KEYS = (
    "dipole_limit_Am2",
    "full_power_W",
    "turns",
    "coil_area_m2",
    "resistance_ohm",
    "duty",
)
THRUSTER_KEYS = (
    "torque_directions",
    "torque_limit_Nm",
    "minimum_on_time_s",
    "minimum_impulse_Nms",
)
PANEL_KEYS = ("normals", "area_m2", "efficiency", "shades", "incidence")
BATTERY_KEYS = (
    "capacity_Wh",
    "capacity_J",
    "charge_percent",
    "charge_Wh",
    "charge_J",
    "input_efficiency",
    "output_efficiency",
)
LOAD_KEYS = ("harvest_W", "image_W", "communicate_W", "idle_W")
VEHICLE_PARTS: Mapping[str, tuple[str, ...]] = {
    "wheels": WHEEL_KEYS,
    "thrusters": THRUSTER_KEYS,
    "magnetorquers": MAGNETORQUER_KEYS,
    "panels": PANEL_KEYS,
    "battery": BATTERY_KEYS,
    "loads": LOAD_KEYS,
}
"""Tables inside [vehicle]."""
LIGHT_KEYS = (
    "irradiance_W_m2",
    "sun_inertial",
    "sun_distance_m",
    "shadow",
    "penumbra",
    "earth_radius_m",
    "sun_radius_m",
)
VEHICLE_FILE_KEYS = (
    "name",
    "title",
    "source",
    "inertia_kgm2",
    *VEHICLE_PARTS,
)

SPACECRAFT_TABLES: Mapping[str, tuple[str, ...]] = {
    "vehicle": ("use", "file", *VEHICLE_FILE_KEYS),
    "orbit": (
        "tle",
        "tle_file",
        "omm_file",
        "oem_file",
        "object",
        "perturbations",
        "elements",
        "semi_major_axis_km",
        "eccentricity",
        "inclination_deg",
        "raan_deg",
        "argument_of_periapsis_deg",
        "true_anomaly_deg",
        "gravitational_parameter_m3_s2",
        "epoch",
    ),
    "initial": (*POSE_KEYS, "rate_rad_s", "rate", "wheel_speed_rad_s", *FILE_KEYS),
    "target": _TARGET,
    "legs": _TARGET,
    "waypoint": (*POSE_KEYS, "time_s", "node", "tolerance_deg"),
    "horizon": _HORIZON,
    "disturbances": (
        "gravity_gradient",
        "sinusoidal_torque_Nm",
        "sinusoidal_frequency_rad_s",
    ),
    "control": ("axes", "quantisation"),
    "objective": (
        "kind",
        "terminal",
        "design",
        "epsilon_Nm",
        "rate_weight_s2",
        "attitude_weight",
        "sparsity_weight",
        "waypoint_weight",
        "on_off_weight",
        "on_off_form",
        "time_weight_1_s",
        "effort_weight",
    ),
    "transcription": ("attitude", "integration"),
    "windows": _WINDOW,
    "keep_out": _CONE,
    "keep_in": _CONE,
    "limits": ("body_rate_deg_s",),
    "solver": _SOLVER,
    "printed": (),
}

TOY_TABLES: Mapping[str, tuple[str, ...]] = {
    "initial": ("state",),
    "target": ("state", "tolerance"),
    "horizon": _HORIZON,
    "control": ("limit",),
    "objective": ("kind", "terminal", "epsilon", "time_weight_1_s"),
    "windows": _WINDOW,
    "solver": _SOLVER,
    "printed": (),
}

# Longest suffix first: rate_rad_s ends in both "_rad_s" and "_s".
UNITS = {
    "_m3_s2": "m^3/s^2",
    "_rad_s": "rad/s",
    "_kgm2": "kg m^2",
    "_W_m2": "W/m^2",
    "_deg_s": "degrees a second",
    "_deg": "degrees",
    "_rad": "radians",
    "_km": "kilometres",
    "_Am2": "A m^2",
    "_m2": "m^2",
    "_percent": "percent",
    "_ohm": "ohms",
    "_Wh": "watt hours",
    "_Nms": "newton metre seconds",
    "_Nm": "newton metres",
    "_s2": "s^2",
    "_1_s": "1/s",
    "_W": "watts",
    "_J": "joules",
    "_m": "metres",
    "_s": "seconds",
}


def top_level_keys(tables: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """Return the keys that are allowed at the top of a scenario file with these tables."""
    return (*_TOP, *tables)


def unit_of(key: str) -> str | None:
    """Return the unit that a key's name carries, in words, or None."""
    return next((unit for suffix, unit in UNITS.items() if key.endswith(suffix)), None)


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate that was most likely meant by `name`, or None.

    A candidate that is `name` with a unit added comes first: a forgotten unit is the commonest
    slip, and plain similarity would prefer a shorter key.
    """
    names = {candidate.lower(): candidate for candidate in candidates}
    low = name.lower()
    meant = _with_unit(low, names.values())
    if meant is not None:
        return meant
    close = difflib.get_close_matches(low, names, n=1, cutoff=0.6)
    return names[close[0]] if close else None


def _with_unit(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate that is `name`, in lower case, with a unit added, or None."""
    for candidate in candidates:
        for suffix in UNITS:
            if candidate.endswith(suffix) and name == candidate[: -len(suffix)].lower():
                return candidate
    return None


def unknown_key_mend(table: str, key: str, allowed: tuple[str, ...]) -> str:
    """Return the sentence that helps with an unknown key: a close name, or all allowed ones."""
    # A key that exists in another table was misplaced rather than misspelt.
    elsewhere = {
        **{f"vehicle.{part}": keys for part, keys in VEHICLE_PARTS.items()},
        **SPACECRAFT_TABLES,
    }
    for other, keys in elsewhere.items():
        if other != table and key in keys and _with_unit(key.lower(), allowed) is None:
            return f"did you mean to put it into [{other}]?"
    near = nearest(key, allowed)
    if near is not None:
        unit = " (units are part of the name)" if unit_of(near) else ""
        return f"did you mean '{near}'?{unit}"
    return f"allowed here: {', '.join(allowed)}"
