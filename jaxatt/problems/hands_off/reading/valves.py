"""Check that a scenario asks of thrusters only what they can do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario_parts import Horizon, Objective
from jaxatt.spacecraft.checks import Float64
from jaxatt.spacecraft.parts.vehicle import Spacecraft


def shortest_interval(vehicle: Spacecraft | None) -> float:
    """Shortest control interval [s] in which every valve can open and shut."""
    if vehicle is None or not vehicle.thrusters.count:
        return 0.0
    return float(max(shortest.max() for _, shortest, _ in _openings(vehicle)))


def _openings(vehicle: Spacecraft) -> tuple[tuple[str, Float64, str], ...]:
    """Key in the file, shortest opening of each valve [s] and its unit in the file."""
    thrusters = vehicle.thrusters
    least = np.asarray(thrusters.minimum_impulse) / np.asarray(thrusters.torque_limit)
    return (
        ("minimum_on_time_s", np.asarray(thrusters.minimum_on_time), "s"),
        ("minimum_impulse_Nms", least, "s at the torque limit"),
    )


def check_thrusters(
    document: Mapping[str, Any],
    origin: str,
    vehicle: Spacecraft,
    horizon: Horizon,
    objective: Objective,
) -> None:
    """Refuse what thrusters cannot do: pulses longer than an interval, waypoints, designs 2 and 3.

    Raises `ScenarioError`.
    """
    if not vehicle.thrusters.count:
        return
    for key, shortest, unit in _openings(vehicle):
        step = (horizon.longest if horizon.free else horizon.duration) / horizon.intervals
        if (shortest > step * (1.0 + 1e-12)).any():
            raise ScenarioError(
                f"{origin}: [vehicle.thrusters] {key}: {shortest.max():g} {unit} is longer than a "
                f"control interval of {step:g} s; shorten it, or use fewer intervals"
            )
    if "waypoint" in document:
        raise ScenarioError(
            f"{origin}: [waypoint]: not available with thrusters; drop it or use [[legs]]"
        )
    if objective.design != 1:
        raise ScenarioError(
            f"{origin}: [objective] design = {objective.design}: thrusters share one "
            "complementarity vector; use design = 1"
        )
