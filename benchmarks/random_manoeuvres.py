"""Manoeuvres of random vehicles in motion at both ends, with momentum in the wheels.

A vehicle has 1 to 500 kg, about the density of a CubeSat and four wheels in any mounting.  The
capacity of a wheel is twice the body's largest momentum at 10 deg/s, its torque empties it in 10 to
30 s, and it begins with up to half of it, either way.  The rates at either end are up to 10 deg/s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jaxatt import scenarios
from jaxatt.problems.scenario import Scenario
from jaxatt.runtime.arrays import Floats

KINDS = ("slew", "turn")
INTERVALS = {"slew": 36, "turn": 32}
SUBSTEPS = 6
"""Runge-Kutta steps an interval on both sides, so that one program serves all cases."""
WHEELS = 4
_FASTEST = float(np.radians(10.0))
_FULL_RAD_S = 600.0
_ORBIT = {
    "semi_major_axis_km": 6898.0,
    "eccentricity": 0.0,
    "inclination_deg": 97.5,
    "raan_deg": 30.0,
    "argument_of_periapsis_deg": 0.0,
    "true_anomaly_deg": 0.0,
}


@dataclass(frozen=True)
class Case:
    """A manoeuvre and what it was drawn as.

    mass : [kg].  rate, end_rate : [deg/s].  stored : momentum of the wheels in units of the
    capacity of one.  horizon : [s]; None where the time is free.
    """

    scenario: Scenario
    mass: float
    rate: float
    end_rate: float
    stored: float
    horizon: float | None


def draw(kind: str, index: int, seed: int) -> Case:
    """Draw a case; it depends on its kind, its number and the seed alone.

    kind : "slew" for the fewest active intervals in a given time, "turn" for the least time.
    """
    rng = np.random.default_rng((seed, KINDS.index(kind), index))
    mass = float(10.0 ** rng.uniform(0.0, np.log10(500.0)))
    inertia = _inertia(rng, mass)
    capacity = 2.0 * float(np.linalg.eigvalsh(inertia).max()) * _FASTEST
    emptied = float(rng.uniform(10.0, 30.0))
    axes = _axes(rng)
    speed = _FULL_RAD_S * rng.uniform(-0.5, 0.5, WHEELS)
    rate, end_rate = (_FASTEST * rng.uniform() * _unit(rng, 3) for _ in range(2))
    target = {
        "attitude_quaternion": _unit(rng, 4).tolist(),
        "rate_rad_s": end_rate.tolist(),
        "attitude_tolerance_deg": 0.05,
        "rate_tolerance_rad_s": 1e-4,
    }
    document: dict[str, Any] = {
        "name": f"random-{kind}-{seed}-{index}",
        "vehicle": {
            "inertia_kgm2": inertia.tolist(),
            "wheels": {
                "axes": axes.T.tolist(),
                "inertia_kgm2": capacity / _FULL_RAD_S,
                "torque_limit_Nm": capacity / emptied,
            },
        },
        "initial": {
            "attitude_quaternion": _unit(rng, 4).tolist(),
            "rate_rad_s": rate.tolist(),
            "wheel_speed_rad_s": speed.tolist(),
        },
        "target": target,
        "horizon": {"intervals": INTERVALS[kind], "substeps": SUBSTEPS},
        "objective": {"kind": "l0" if kind == "slew" else "minimum-time"},
    }
    horizon = None
    if kind == "slew":
        # The wheels brake 10 deg/s within half the time that empties them.
        horizon = 0.5 * emptied * float(rng.uniform(4.0, 7.0))
        document["horizon"] |= {"horizon_s": horizon, "coast_intervals": 0}
        document["orbit"] = _ORBIT
    return Case(
        scenarios.from_mapping(document),
        mass,
        *(float(np.degrees(np.linalg.norm(each))) for each in (rate, end_rate)),
        float(np.linalg.norm(axes @ speed)) / _FULL_RAD_S,
        horizon,
    )


def _unit(rng: np.random.Generator, size: int) -> Floats:
    v = rng.normal(size=size)
    return np.asarray(v / np.linalg.norm(v))


def _inertia(rng: np.random.Generator, mass: float) -> Floats:
    """Inertia (3, 3) [kg m^2] of random point masses in a box as large as such a mass is."""
    points = rng.normal(size=(20, 3)) * rng.uniform(0.7, 1.3, 3)
    spread = np.einsum("pi,pj->ij", points, points)
    shape = np.trace(spread) * np.eye(3) - spread
    side = 0.1 * mass ** (1.0 / 3.0)
    return np.asarray(0.5 * mass * side**2 * shape / np.trace(shape))


def _axes(rng: np.random.Generator) -> Floats:
    """Axes (3, n) of wheels that can turn the body about any axis with room to spare."""
    while True:
        axes = rng.normal(size=(3, WHEELS))
        axes /= np.linalg.norm(axes, axis=0)
        if np.linalg.svd(axes, compute_uv=False)[-1] > 0.5:
            return np.asarray(axes)
