"""Read the scenario of a sparse manoeuvre of a spacecraft from a TOML document."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from jaxatt.problems.hands_off.reading.objective import PRINTED, check_free_time, read_objective
from jaxatt.problems.hands_off.reading.valves import check_thrusters
from jaxatt.problems.hands_off.reading.windows import read_windows
from jaxatt.problems.reading import manoeuvre, settings
from jaxatt.problems.reading.directions import sky_over
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.heading import read_heading
from jaxatt.problems.reading.moments import moments_of
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.problems.reading.pointing import check_moments, read_pointing
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.scenario import Control, Horizon, Scenario
from jaxatt.spacecraft import Spacecraft


def read_hands_off(document: dict[str, Any], origin: str, folder: Path | None) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    heading = read_heading(document, origin, SPACECRAFT_TABLES, PRINTED)
    notes: list[str] = []
    vehicle = read_vehicle(document["vehicle"], origin, folder, notes)
    objective = read_objective(document.get("objective", {}), origin, vehicle)
    if "transcription" in document:
        raise ScenarioError(
            f"{origin}: [transcription]: not used by kind = {objective.kind}; drop it, or use an "
            "objective that minimises time"
        )
    horizon = settings.read_horizon(document["horizon"], origin)
    check_free_time(document, origin, horizon, objective)
    windows = read_windows(document.get("windows", []), origin, horizon)
    if objective.kind == "moving-l0" and all(window.forbidden for window in windows):
        notes.append("moving-l0 without a cheap window is the same as l0; add [[windows]]")
    if "orbit" not in document and not vehicle.thrusters.count:
        raise ScenarioError(
            f"{origin}: [orbit] is missing; `jaxatt scenarios show NAME` prints a complete file to "
            "start from (only vehicles with thrusters and turns in minimum time may do without, in "
            "the inertial frame)"
        )
    orbit = None
    if "orbit" in document:
        orbit = read_orbit(document["orbit"], origin, folder, notes)
        orbit = covering(orbit, document["orbit"], origin, _length(horizon, _phases(document)))
    sky = sky_over(orbit, folder)
    targets = manoeuvre.read_targets(document, origin, notes, sky, horizon, vehicle.wheels)
    if vehicle.thrusters.count and any(target.wheel_bias is not None for target in targets):
        raise ScenarioError(
            f"{origin}: [target] wheel_bias_rad_s: not beside thrusters; drop it, or drop "
            "[vehicle.thrusters]"
        )
    waypoint = None
    if "waypoint" in document:
        if len(targets) > 1 or "legs" in document:
            raise ScenarioError(f"{origin}: [waypoint] and [[legs]] are both given; keep one")
        waypoint = manoeuvre.read_waypoint(document["waypoint"], origin, horizon, notes, sky)
    disturbances = settings.read_disturbances(document.get("disturbances", {}), origin, horizon)
    if disturbances.gravity_gradient and orbit is None:
        raise ScenarioError(
            f"{origin}: [disturbances] gravity_gradient = true: there is no [orbit]; add one or "
            "switch the gravity gradient off"
        )
    control = _read_control(document.get("control", {}), origin, vehicle)
    check_thrusters(document, origin, vehicle, horizon, objective)
    pointing = read_pointing(
        document,
        origin,
        notes,
        sky,
        (horizon.shortest if horizon.free else horizon.duration) * len(targets),
        _length(horizon, len(targets)),
    )
    scenario = Scenario(
        **vars(heading),
        family="hands-off",
        vehicle=vehicle,
        orbit=orbit,
        initial=manoeuvre.read_initial(document["initial"], origin, vehicle, notes, sky),
        targets=targets,
        waypoint=waypoint,
        horizon=horizon,
        disturbances=disturbances,
        control=control,
        objective=objective,
        windows=windows,
        notes=tuple(notes),
        document=document,
        origin=origin,
        folder=folder,
        pointing=pointing,
    )
    if scenario.pointing:
        check_moments(scenario.pointing, moments_of(scenario), origin)
    return scenario


def _phases(document: dict[str, Any]) -> int:
    """Number of phases, before their targets are read."""
    legs = document.get("legs")
    return len(legs) if isinstance(legs, list) else 1


def _length(horizon: Horizon, phases: int) -> float:
    """Longest time [s] that all phases take, with the flight after the end."""
    longest = horizon.longest if horizon.free else horizon.duration
    return longest * (phases + horizon.coast_intervals / horizon.intervals)


def _read_control(data: Any, origin: str, vehicle: Spacecraft) -> Control:
    """Read the control axes, and the kind of quantisation."""
    table = Table(data, origin, "[control]", SPACECRAFT_TABLES["control"])
    if vehicle.thrusters.count == 0:
        if "quantisation" in table:
            table.fail("quantisation", "the vehicle has no thrusters", "drop it")
        return Control(table.choice("axes", "body"), math.inf)
    axes = table.choice("axes", "wheels")
    if axes == "body":
        table.fail(
            "axes", "thrusters are optimised one by one", 'use axes = "wheels" or leave it out'
        )
    return Control(axes, math.inf, table.choice("quantisation", "pulse-width"))
