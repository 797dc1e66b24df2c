"""Read the parts of a sparse manoeuvre that take no computing, and so no JAX."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

from jaxatt.problems.hands_off.reading.objective import PRINTED, check_free_time, read_objective
from jaxatt.problems.hands_off.reading.valves import check_thrusters
from jaxatt.problems.hands_off.reading.windows import read_windows
from jaxatt.problems.reading import settings
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.heading import Heading, read_heading
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.reading.wheel_speeds import read_initial_speeds
from jaxatt.problems.scenario_parts import Control, Disturbances, Horizon, Objective, Window
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.parts.vehicle import Spacecraft
from jaxatt.spacecraft.scale import largest_torque_limit


class Parts(NamedTuple):
    """What was read; speeds : (n,) [rad/s], of the wheels at the start."""

    heading: Heading
    vehicle: Spacecraft
    objective: Objective
    horizon: Horizon
    windows: tuple[Window, ...]
    disturbances: Disturbances
    control: Control
    speeds: Floats


def read_parts(
    document: dict[str, Any], origin: str, folder: Path | None, notes: list[str], faults: Faults
) -> Parts:
    """Read the parts; arguments as for `Family.read`, and notes, to which remarks are added."""
    heading = faults.of(read_heading, document, origin, SPACECRAFT_TABLES, PRINTED)
    vehicle = faults.of(read_vehicle, faults.table(document, "vehicle"), origin, folder, notes)
    torque = faults.or_else(faults.of(largest_torque_limit, vehicle), 1.0)
    objective = faults.of(read_objective, document.get("objective", {}), origin, torque)
    faults.of(_refuse_transcription, document, origin, objective)
    horizon = faults.of(settings.read_horizon, faults.table(document, "horizon"), origin)
    faults.of(check_free_time, document, origin, horizon, objective)
    windows = faults.of(read_windows, document.get("windows", []), origin, horizon)
    faults.of(_note_windows, windows, objective, notes)
    faults.of(_check_orbit, document, origin, vehicle)
    disturbances = faults.of(
        settings.read_disturbances, document.get("disturbances", {}), origin, horizon
    )
    faults.of(_check_gravity_gradient, document, origin, disturbances)
    control = faults.of(_read_control, document.get("control", {}), origin, vehicle)
    faults.of(check_thrusters, document, origin, vehicle, horizon, objective)
    speeds = faults.of(
        read_initial_speeds, faults.table(document, "initial"), origin, vehicle.wheels
    )
    return Parts(heading, vehicle, objective, horizon, windows, disturbances, control, speeds)


def _refuse_transcription(document: dict[str, Any], origin: str, objective: Objective) -> None:
    if "transcription" in document:
        raise ScenarioError(
            f"{origin}: [transcription]: not used by kind = {objective.kind}; drop it, or use an "
            "objective that minimises time"
        )


def _note_windows(windows: tuple[Window, ...], objective: Objective, notes: list[str]) -> None:
    if objective.kind == "moving-l0" and all(window.forbidden for window in windows):
        notes.append("moving-l0 without a cheap window is the same as l0; add [[windows]]")


def _check_orbit(document: dict[str, Any], origin: str, vehicle: Spacecraft) -> None:
    if "orbit" not in document and not vehicle.thrusters.count:
        raise ScenarioError(
            f"{origin}: [orbit] is missing; `jaxatt scenarios show NAME` prints a complete file to "
            "start from (only vehicles with thrusters and turns in minimum time may do without, in "
            "the inertial frame)"
        )


def _check_gravity_gradient(
    document: dict[str, Any], origin: str, disturbances: Disturbances
) -> None:
    if disturbances.gravity_gradient and "orbit" not in document:
        raise ScenarioError(
            f"{origin}: [disturbances] gravity_gradient = true: there is no [orbit]; add one or "
            "switch the gravity gradient off"
        )


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
