"""A plan of four short tasks, small enough to be solved in a test."""

from __future__ import annotations

import copy
from typing import Any

DOCUMENT: dict[str, Any] = {
    "name": "short",
    "title": "Two harvests, an image and a pass",
    "source": "test",
    "vehicle": {
        "use": "hypso1-solar",
        "battery": {"capacity_Wh": 1.0, "charge_percent": 50.0},
        "loads": {"harvest_W": 12.0, "image_W": 8.0, "communicate_W": 10.0},
        # So poor that the turn that earns the most is far from the fastest.
        "wheels": {"efficiency": 0.1},
    },
    "orbit": {
        "semi_major_axis_km": 6905.1,
        "eccentricity": 0.0007757,
        "inclination_deg": 97.439,
        "raan_deg": 139.3136,
        "argument_of_periapsis_deg": 33.7547,
        "true_anomaly_deg": 69.0,
        "epoch": "2023-03-14T09:35:11Z",
    },
    "light": {"irradiance_W_m2": 1361.0},
    "initial": {
        "attitude_quaternion": [0.0, 0.0, 1.0, 0.0],
        "wheel_speed_rad_s": [0.0, 0.0, 0.0],
    },
    "objective": {"kind": "net-power", "wheel_power": "body"},
    "baseline": {"attitude_gain_Nm": 8e-2, "rate_gain_Nm_s": 0.108, "turn_back_s": 20.0},
    "solver": {"starts": 4, "seed": 0},
    "horizon": {"step_s": 1.25},
    "limits": {"least_charge_percent": 10.0},
    "plan": {"joint": False},
    "tasks": [
        {"name": "first harvest", "mode": "harvest", "duration_s": 40.0},
        {
            "name": "Finnmark",
            "mode": "image",
            "duration_s": 20.0,
            "attitude_quaternion": [0.084, 0.918, -0.329, -0.205],
            "rate_deg_s": [0.0, -0.754, 0.0],
            "target_deg": [70.5, 26.0],
        },
        {"name": "second harvest", "mode": "harvest", "duration_s": 40.0},
        {
            "name": "Svalbard",
            "mode": "communicate",
            "duration_s": 20.0,
            "attitude_quaternion": [0.853, 0.372, -0.019, -0.366],
            "target_deg": [78.23, 15.39],
        },
    ],
}


def short_plan(changes: dict[str, Any] | None = None) -> dict[str, Any]:
    """The document with "table.key" replaced; None drops one."""
    document = copy.deepcopy(DOCUMENT)
    for path, value in (changes or {}).items():
        *parents, key = path.split(".")
        place: Any = document
        for part in parents:
            place = place[int(part)] if isinstance(place, list) else place.setdefault(part, {})
        place.pop(key, None)
        if value is not None:
            place[key] = value
    return document
