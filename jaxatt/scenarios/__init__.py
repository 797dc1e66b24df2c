"""Scenarios: TOML files of the published cases, and the loader that checks them."""

from jaxatt.problems.hands_off.windows import forbidden_mask, window_mask, window_weights
from jaxatt.problems.manoeuvre import InitialState, Target, Waypoint
from jaxatt.problems.reading.attitudes import quaternion_from_angles
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.vehicles import load_vehicle, vehicle_names
from jaxatt.problems.scenario import (
    SPACECRAFT,
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
from jaxatt.scenarios.bundled import kind_of, names, text, titles
from jaxatt.scenarios.catalog import load, load_flight
from jaxatt.scenarios.flight_loader import flight_from_mapping, replace_in_flight
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.scenarios.loader import from_mapping, load_file, replace

__all__ = [
    "SPACECRAFT",
    "Control",
    "Disturbances",
    "FlightScenario",
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
    "flight_from_mapping",
    "forbidden_mask",
    "from_mapping",
    "kind_of",
    "load",
    "load_file",
    "load_flight",
    "load_vehicle",
    "names",
    "quaternion_from_angles",
    "replace",
    "replace_in_flight",
    "text",
    "titles",
    "vehicle_names",
    "window_mask",
    "window_weights",
]
