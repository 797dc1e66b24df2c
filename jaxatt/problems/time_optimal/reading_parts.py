"""Read the parts of a turn in free time that take no computing, and so no JAX."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from jaxatt.problems.reading import settings
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.free_time import read_final_time
from jaxatt.problems.reading.heading import Heading, read_heading
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.objective import TIME_KINDS
from jaxatt.problems.reading.vehicles import read_vehicle
from jaxatt.problems.reading.wheel_speeds import read_initial_speeds
from jaxatt.problems.scenario_parts import Control, Horizon, Objective, Transcription
from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.parts.vehicle import Spacecraft
from jaxatt.spacecraft.scale import largest_torque_limit

_COMPARED = {"final_time_s": 1, "final_time_below_s": 1, "step_s": 1}
_PRINTED = {kind: _COMPARED for kind in TIME_KINDS}
_DEFAULT_WEIGHT, _TORQUE_LIMIT = 0.01, 0.55
"""rho [1/(N m)^2] of the source's section 6, and the limit of its wheels [N m]."""
_SPARSE_KEYS = (
    "design",
    "time_weight_1_s",
    "epsilon_Nm",
    "rate_weight_s2",
    "attitude_weight",
    "sparsity_weight",
    "waypoint_weight",
    "on_off_weight",
    "on_off_form",
)
"""Keys of [objective] that mean nothing here."""
_ELSEWHERE = {
    "orbit": "such turns are solved in the inertial frame",
    "disturbances": "such turns are solved without external torques",
    "legs": "such turns have one target",
    "waypoint": "such turns pass no waypoint",
    "windows": "such turns may use every interval",
}


class Parts(NamedTuple):
    """What was read; speeds : (n,) [rad/s], of the wheels at the start."""

    heading: Heading
    vehicle: Spacecraft
    objective: Objective
    horizon: Horizon
    control: Control
    transcription: Transcription
    speeds: Floats


def read_parts(
    document: dict[str, Any], origin: str, folder: Path | None, notes: list[str], faults: Faults
) -> Parts:
    """Read the parts; arguments as for `Family.read`, and notes, to which remarks are added."""
    heading = faults.of(read_heading, document, origin, SPACECRAFT_TABLES, _PRINTED)
    vehicle = faults.of(read_vehicle, faults.table(document, "vehicle"), origin, folder, notes)
    torque = faults.or_else(faults.of(largest_torque_limit, vehicle), _TORQUE_LIMIT)
    objective = faults.of(_read_objective, document["objective"], origin, torque)
    faults.of(_check_document, document, origin, notes)
    horizon = faults.of(_read_horizon, faults.table(document, "horizon"), origin)
    control = faults.of(_read_control, document.get("control", {}), origin)
    transcription = faults.of(_read_transcription, document.get("transcription", {}), origin)
    speeds = faults.of(
        read_initial_speeds, faults.table(document, "initial"), origin, vehicle.wheels
    )
    return Parts(heading, vehicle, objective, horizon, control, transcription, speeds)


def _check_document(document: Mapping[str, Any], origin: str, notes: list[str]) -> None:
    """Refuse tables and keys that have no meaning where time is minimised.

    Raises `ScenarioError`.
    """
    objective = Table(document["objective"], origin, "[objective]", SPACECRAFT_TABLES["objective"])
    kind = objective.text("kind")
    faults = Faults()
    for name, reason in _ELSEWHERE.items():
        if name in document:
            faults.add(
                ScenarioError(f"{origin}: {name}: not with kind = {kind}; {reason}, drop it")
            )
    faults.of(_check_objective, objective, kind)
    faults.refuse()
    if kind == "minimum-time" and "effort_weight" in objective:
        notes.append("[objective] effort_weight is not used by kind = minimum-time")


def _check_objective(table: Table, kind: str) -> None:
    if table.choice("terminal") == "penalty":
        table.fail("terminal", f"kind = {kind} always reaches", 'use "reach" or leave it out')
    for key in _SPARSE_KEYS:
        if key in table:
            table.fail(key, "belongs to the sparse objectives", f"drop it for kind = {kind}")


def _read_objective(data: Any, origin: str, torque: float) -> Objective:
    table = Table(data, origin, "[objective]", SPACECRAFT_TABLES["objective"])
    kind = table.choice("kind")
    usual = _DEFAULT_WEIGHT * (_TORQUE_LIMIT / torque) ** 2
    weight = table.number("effort_weight", usual)
    return Objective(
        kind=kind,
        effort_weight=weight if kind == "time-effort" else 0.0,
    )


def _read_horizon(data: Any, origin: str) -> Horizon:
    """Read a horizon whose time is found: the number of intervals, and limits of the time."""
    table = Table(data, origin, "[horizon]", SPACECRAFT_TABLES["horizon"])
    if table.choice("final_time", "free") == "fixed":
        table.fail("final_time", "this objective finds the final time", 'use "free" or drop it')
    for key, mend in (
        ("horizon_s", "drop it; shortest_s and longest_s limit it"),
        ("coast_intervals", "drop it"),
    ):
        if key in table:
            table.fail(key, "this objective finds the final time, and nothing follows it", mend)
    _, shortest, longest = read_final_time(table, "free")
    intervals = table.integer("intervals")
    return Horizon(
        duration=longest,
        intervals=intervals,
        coast_intervals=0,
        substeps=settings.read_substeps(table, intervals),
        free=True,
        shortest=shortest,
        longest=longest,
    )


def _read_transcription(data: Any, origin: str) -> Transcription:
    """Read the attitude coordinates and the integration method."""
    table = Table(data, origin, "[transcription]", SPACECRAFT_TABLES["transcription"])
    return Transcription(
        attitude=table.choice("attitude"),
        integration=table.choice("integration"),
    )


def _read_control(data: Any, origin: str) -> Control:
    """Read the control of such a turn: each wheel and thruster by itself, not quantised."""
    table = Table(data, origin, "[control]", SPACECRAFT_TABLES["control"])
    for key, only in (("axes", "wheels"), ("quantisation", "none")):
        if key in table and table.data[key] != only:
            table.fail(key, "not where time is minimised", f'use "{only}" or leave it out')
    return Control("wheels", math.inf, "none")
