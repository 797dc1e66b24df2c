"""Parts of a scenario, under the names that users write."""

from jaxatt.problems.hands_off.windows import forbidden_mask, window_mask, window_weights
from jaxatt.problems.manoeuvre import InitialState, Target, Waypoint
from jaxatt.problems.reading.attitudes import quaternion_from_angles
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.schema import SPACECRAFT
from jaxatt.problems.reading.vehicles import load_vehicle, vehicle_names
from jaxatt.problems.scenario import (
    Control,
    Disturbances,
    Horizon,
    Objective,
    Orbit,
    Scenario,
    SolverSettings,
    Transcription,
    Window,
)

__all__ = [
    "SPACECRAFT",
    "Control",
    "Disturbances",
    "Horizon",
    "InitialState",
    "Objective",
    "Orbit",
    "Scenario",
    "ScenarioError",
    "SolverSettings",
    "Target",
    "Transcription",
    "Waypoint",
    "Window",
    "forbidden_mask",
    "load_vehicle",
    "quaternion_from_angles",
    "vehicle_names",
    "window_mask",
    "window_weights",
]
