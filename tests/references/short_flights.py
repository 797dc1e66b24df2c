"""Small flights for the tests of the closed loop."""

from __future__ import annotations

from dataclasses import dataclass

import jax

from jaxatt.attitude.components import Vector
from jaxatt.scenarios import flight_from_mapping

LEVER = [0.05, 0.10, 0.15]
ELEMENTS = {
    "semi_major_axis_km": 6852.2,
    "eccentricity": 0.002,
    "inclination_deg": 97.0,
    "raan_deg": 280.0,
    "argument_of_periapsis_deg": 0.0,
    "true_anomaly_deg": 90.0,
}


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class ConstantTorque:
    """Open loop: the same torque on the wheels in body axes at every sample."""

    torque: jax.Array

    def initial(self):
        return ()

    def __call__(self, measured, memory, period):
        return Vector.of(self.torque), memory


def flight(**changes):
    """A short flight of HYPSO-1 about a random-looking start; `changes` by table."""
    document = {
        "name": "short",
        "vehicle": {"use": "hypso1", "magnetorquers": {"dipole_limit_Am2": 0.5}},
        "orbit": ELEMENTS,
        "environment": {"gravity_gradient": True},
        "initial": {
            "attitude_deg": [20.0, -30.0, 40.0],
            "rate_rad_s": [0.01, -0.005, 0.008],
            "wheel_speed_rad_s": [100.0, -50.0, 30.0, 20.0],
        },
        "reference": {"attitude_deg": [0.0, 0.0, 0.0]},
        "simulation": {"duration_s": 60.0, "sampling_s": 0.1, "records": 600},
        "laws": {"pd": {"kind": "pd", "proportional_1_s2": 1.0, "derivative_1_s": 2.0}},
        "campaign": {"attitude_deg": 10.0, "inertia_percent": 5.0, "misalignment_deg": 1.0},
    }
    for table, values in changes.items():
        merged = {**document.get(table, {}), **values}
        document[table] = {k: v for k, v in merged.items() if v is not None}
    return flight_from_mapping(document)
