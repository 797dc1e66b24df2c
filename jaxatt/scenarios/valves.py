"""What a scenario with thrusters may ask for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jaxatt.scenarios.fields import ScenarioError
from jaxatt.scenarios.model import Horizon, Objective
from jaxatt.spacecraft import Spacecraft


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
    thrusters = vehicle.thrusters
    if not thrusters.count:
        return
    for key, shortest, unit in (
        ("minimum_on_time_s", np.asarray(thrusters.minimum_on_time), "s"),
        (
            "minimum_impulse_Nms",
            np.asarray(thrusters.minimum_impulse) / np.asarray(thrusters.torque_limit),
            "s at the torque limit",
        ),
    ):
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
