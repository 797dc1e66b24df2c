"""Read the scenario of a sparse manoeuvre of a spacecraft from a TOML document."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from jaxatt.problems.hands_off.reading.objective import PRINTED, check_free_time, read_objective
from jaxatt.problems.hands_off.reading.valves import check_thrusters
from jaxatt.problems.hands_off.reading.windows import read_windows
from jaxatt.problems.manoeuvre import Target, Waypoint
from jaxatt.problems.pointing.case import Pointing
from jaxatt.problems.reading import manoeuvre, settings
from jaxatt.problems.reading.directions import Sky, sky_over
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.heading import read_heading
from jaxatt.problems.reading.moments import moments_of
from jaxatt.problems.reading.orbit import covering, read_orbit
from jaxatt.problems.reading.pointing import check_moments, read_pointing
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.scenario import (
    Control,
    Disturbances,
    Horizon,
    Objective,
    Orbit,
    Scenario,
    Window,
)
from jaxatt.spacecraft import Spacecraft
from jaxatt.spacecraft.scale import largest_torque_limit


def read_hands_off(
    document: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    """Read and check the scenario; see `Family.read`."""
    heading = faults.of(read_heading, document, origin, SPACECRAFT_TABLES, PRINTED)
    notes: list[str] = []
    vehicle = faults.of(read_vehicle, faults.table(document, "vehicle"), origin, folder, notes)
    torque = faults.or_else(faults.of(largest_torque_limit, vehicle), 1.0)
    objective = faults.of(read_objective, document.get("objective", {}), origin, torque)
    faults.of(_refuse_transcription, document, origin, objective)
    horizon = faults.of(settings.read_horizon, faults.table(document, "horizon"), origin)
    faults.of(check_free_time, document, origin, horizon, objective)
    windows = faults.of(read_windows, document.get("windows", []), origin, horizon)
    faults.of(_note_windows, windows, objective, notes)
    orbit = faults.of(_read_orbit, document, origin, folder, notes)
    faults.of(_check_orbit, origin, vehicle, orbit)
    orbit = faults.of(_covering, document, origin, orbit, horizon)
    sky = faults.of(sky_over, orbit, folder)
    targets = faults.of(
        manoeuvre.read_targets, document, origin, notes, sky, horizon, vehicle.wheels
    )
    faults.of(_check_bias, origin, vehicle, targets)
    waypoint = faults.of(_read_waypoint, document, origin, horizon, notes, sky)
    disturbances = faults.of(
        settings.read_disturbances, document.get("disturbances", {}), origin, horizon
    )
    faults.of(_check_gravity_gradient, origin, disturbances, orbit)
    control = faults.of(_read_control, document.get("control", {}), origin, vehicle)
    faults.of(check_thrusters, document, origin, vehicle, horizon, objective)
    pointing = faults.of(_read_pointing, document, origin, notes, sky, horizon)
    initial = manoeuvre.read_initial(
        faults.table(document, "initial"), origin, vehicle, notes, sky, faults
    )
    faults.refuse()
    scenario = Scenario(
        **vars(heading),
        family="hands-off",
        vehicle=vehicle,
        orbit=orbit,
        initial=initial,
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


def _refuse_transcription(document: dict[str, Any], origin: str, objective: Objective) -> None:
    if "transcription" in document:
        raise ScenarioError(
            f"{origin}: [transcription]: not used by kind = {objective.kind}; drop it, or use an "
            "objective that minimises time"
        )


def _note_windows(windows: tuple[Window, ...], objective: Objective, notes: list[str]) -> None:
    if objective.kind == "moving-l0" and all(window.forbidden for window in windows):
        notes.append("moving-l0 without a cheap window is the same as l0; add [[windows]]")


def _read_orbit(
    document: dict[str, Any],
    origin: str,
    folder: Path | None,
    notes: list[str],
) -> Orbit | None:
    if "orbit" not in document:
        return None
    return read_orbit(document["orbit"], origin, folder, notes)


def _covering(
    document: dict[str, Any], origin: str, orbit: Orbit | None, horizon: Horizon
) -> Orbit | None:
    if orbit is None:
        return None
    return covering(orbit, document["orbit"], origin, _length(horizon, _phases(document)))


def _check_orbit(origin: str, vehicle: Spacecraft, orbit: Orbit | None) -> None:
    if orbit is None and not vehicle.thrusters.count:
        raise ScenarioError(
            f"{origin}: [orbit] is missing; `jaxatt scenarios show NAME` prints a complete file to "
            "start from (only vehicles with thrusters and turns in minimum time may do without, in "
            "the inertial frame)"
        )


def _check_bias(origin: str, vehicle: Spacecraft, targets: tuple[Target, ...]) -> None:
    if vehicle.thrusters.count and any(target.wheel_bias is not None for target in targets):
        raise ScenarioError(
            f"{origin}: [target] wheel_bias_rad_s: not beside thrusters; drop it, or drop "
            "[vehicle.thrusters]"
        )


def _read_waypoint(
    document: dict[str, Any], origin: str, horizon: Horizon, notes: list[str], sky: Sky
) -> Waypoint | None:
    if "waypoint" not in document:
        return None
    if "legs" in document:
        raise ScenarioError(f"{origin}: [waypoint] and [[legs]] are both given; keep one")
    return manoeuvre.read_waypoint(document["waypoint"], origin, horizon, notes, sky)


def _check_gravity_gradient(origin: str, disturbances: Disturbances, orbit: Orbit | None) -> None:
    if disturbances.gravity_gradient and orbit is None:
        raise ScenarioError(
            f"{origin}: [disturbances] gravity_gradient = true: there is no [orbit]; add one or "
            "switch the gravity gradient off"
        )


def _read_pointing(
    document: dict[str, Any], origin: str, notes: list[str], sky: Sky, horizon: Horizon
) -> Pointing:
    phases = _phases(document)
    first = (horizon.shortest if horizon.free else horizon.duration) * phases
    return read_pointing(document, origin, notes, sky, first, _length(horizon, phases))


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
