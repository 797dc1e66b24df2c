"""Conversion of a result to a labelled xarray Dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.answer import Answer
from jaxatt.problems.sections import Sections
from jaxatt.records.labels import Label, Variable, labelled
from jaxatt.records.phase import Phase
from jaxatt.records.timeline import at_nodes, node_times
from jaxatt.report.family import sections_of
from jaxatt.report.wheel_coordinates import wheel_coordinates
from jaxatt.spacecraft.wheels import no_wheels

if TYPE_CHECKING:
    import xarray

_SERIES: Mapping[str, Label] = {
    "q_ob": (("time", "quaternion"), "1", "attitude of the body relative to the orbit frame"),
    "omega_ob": (("time", "axis"), "rad/s", "rate relative to the orbit frame, in body axes"),
    "omega_ib": (("time", "axis"), "rad/s", "rate relative to the inertial frame, in body axes"),
    "omega_bw": (("time", "wheel"), "rad/s", "wheel speed relative to the body"),
    "torque_body": (("interval", "axis"), "N m", "torque on the wheels in body axes"),
    "torque_wheels": (("interval", "wheel"), "N m", "torque on each wheel"),
    "torque_motors": (("interval", "wheel"), "N m", "largest torque of each motor, with friction"),
    "torque_thrusters": (("interval", "thruster"), "N m", "torque of each thruster, relaxed"),
}
_REFERENCES: Mapping[str, Label] = {
    "q_ob_reference": (("quaternion",), "1", "target attitude"),
    "waypoint": (("quaternion",), "1", "attitude to pass"),
    "wheel_bias": (("wheel",), "rad/s", "wheel speeds at the end beside those of the momentum"),
    "boresight_reference": (("axis",), "1", "body axis about which the roll is free"),
    "omega_ob_reference": (("axis",), "rad/s", "target rate relative to the orbit frame"),
}
_ERROR_UNITS = {
    "attitude": "rad",
    "rate": "rad/s",
    "waypoint": "rad",
    "wheel bias": "rad/s",
    "state": "1",
}


def to_dataset(result: Answer) -> xarray.Dataset:
    """Labelled arrays of a result in SI units and radians, with settings and versions as
    attributes.

    Dimensions are `time` (nodes, from the phase's start [s]), `interval`, `axis`, `wheel`,
    `quaternion` (scalar first) and `start`, and those of the family's own; where the case has
    several phases, `leg` comes first everywhere.  Where the phases' intervals differ in length or
    number, `time` holds node numbers and `node_time` (phase, time) the times; `fine_time`, of the
    cones' angles, and `fine_node_time` likewise; shorter phases are filled up with NaN.
    """
    import xarray

    sections = sections_of(result)
    alternative = any(phase.alternative is not None for phase in result.phases)
    together = len({(phase.step, len(phase.active)) for phase in result.phases}) == 1
    parts = [
        xarray.Dataset(
            _variables(phase, sections.labels, alternative)
            | dict(sections.variables(phase, result.phases))
            | (
                {}
                if together
                else _times(phase, "node_time")
                | _fine_times(phase, "fine_node_time")
                | _coasting(phase)
            ),
            _coordinates(phase, result)
            | (_coasting(phase) if together else {})
            | dict(sections.coordinates(phase))
            | (_times(phase) | _fine_times(phase) if together else _numbers(phase)),
        )
        for phase in result.phases
    ]
    if len(parts) == 1:
        dataset = parts[0]
    else:
        numbers = xarray.Variable("leg", np.arange(1, len(parts) + 1), {"long_name": "leg"})
        # Phases of different lengths are filled up with values that are not numbers.
        dataset = xarray.concat(
            parts, dim="leg", data_vars="all", coords="minimal", compat="override", join="outer"
        )
        dataset = dataset.assign_coords(leg=numbers)
    return dataset.assign_attrs(_attributes(result, sections))


def _coordinates(phase: Phase, result: Answer) -> dict[str, Variable]:
    count = len(phase.active)
    coordinates: dict[str, Variable] = {
        "interval": (("interval",), np.arange(count), {"long_name": "control interval"}),
        "start": (("start",), np.arange(len(phase.starts.status)), {"long_name": "start"}),
    }
    if phase.pointing is not None:
        cones = [e for e in phase.pointing.extremes if e.kind != "body-rate"]
        coordinates["cone"] = (("cone",), [e.name for e in cones], {"long_name": "cone"})
        coordinates["cone_kind"] = (("cone",), [e.kind for e in cones], {"long_name": "kind"})
        coordinates["cone_half_angle"] = (
            ("cone",),
            [e.allowed for e in cones],
            {"units": "rad", "long_name": "half angle"},
        )
    if "q_ob" in phase.series:
        coordinates["axis"] = (("axis",), ["x", "y", "z"], {"long_name": "body axis"})
        if "omega_bw" in phase.series:
            vehicle = result.scenario.vehicle
            coordinates |= wheel_coordinates(no_wheels() if vehicle is None else vehicle.wheels)
        if "torque_thrusters" in phase.series:
            count = phase.series["torque_thrusters"].shape[1]
            words = {"long_name": "thruster"}
            coordinates["thruster"] = (("thruster",), np.arange(1, count + 1), words)
        coordinates["quaternion"] = (
            ("quaternion",),
            ["w", "x", "y", "z"],
            {"long_name": "quaternion component, scalar first"},
        )
    return coordinates


def _coasting(phase: Phase) -> dict[str, Variable]:
    ended = node_times(phase) > phase.step * (len(phase.active) + 0.5)
    return {"coasting": (("time",), ended, {"long_name": "whether the horizon has ended"})}


def _times(phase: Phase, nodes: str = "time") -> dict[str, Variable]:
    """Times of nodes and intervals from the phase's start."""
    return {
        nodes: (
            ("time",),
            node_times(phase),
            {"units": "s", "long_name": "time from the leg's start"},
        ),
        "interval_start": (
            ("interval",),
            phase.step * np.arange(len(phase.active)),
            {"units": "s", "long_name": "start of the interval from the leg's start"},
        ),
    }


def _numbers(phase: Phase) -> dict[str, Variable]:
    """Node numbers, for results whose node times differ from phase to phase."""
    numbers: dict[str, Variable] = {
        "time": (("time",), np.arange(len(node_times(phase))), {"long_name": "node"})
    }
    if phase.pointing is not None:
        count, words = len(phase.pointing.time), {"long_name": "Runge-Kutta step"}
        numbers["fine_time"] = (("fine_time",), np.arange(count), words)
    return numbers


def _fine_times(phase: Phase, nodes: str = "fine_time") -> dict[str, Variable]:
    """Instants between the nodes at which cones are looked at, from the phase's start."""
    if phase.pointing is None:
        return {}
    words = {"units": "s", "long_name": "every Runge-Kutta step, from the leg's start"}
    return {nodes: (("fine_time",), phase.pointing.time, words)}


def _label(phase: Phase, name: str, own: Mapping[str, Label]) -> Label:
    """Axes, unit and words of a series or reference."""
    known = {**_SERIES, **_REFERENCES, **own}
    if name in known:
        return known[name]
    series = name.removesuffix("_reference")
    values = phase.series[name] if name in phase.series else phase.reference[series]
    inner = tuple(f"{series}_{i + 1}" for i in range(np.ndim(values) - (name in phase.series)))
    if name not in phase.series:
        return inner, "", f"target of {series}"
    return ("time" if at_nodes(phase, name) else "interval", *inner), "", name


def _variables(phase: Phase, own: Mapping[str, Label], alternative: bool) -> dict[str, Variable]:
    variables = {
        name: labelled(values, *_label(phase, name, own)) for name, values in phase.series.items()
    }
    for name, values in phase.reference.items():
        key = name if name in _REFERENCES else f"{name}_reference"
        variables[key] = labelled(values, *_label(phase, key, own))
    variables |= {
        "active": labelled(phase.active, ("interval",), "", "whether above the threshold"),
        "leg_start": labelled(phase.start_time, (), "s", "time at which the leg starts"),
        "reached": labelled(phase.reached, (), "", "whether the flight is within all tolerances"),
        "effort": labelled(
            phase.l1_effort,
            (),
            "N m s" if "q_ob" in phase.series else "1",
            "L1 effort over all axes",
        ),
        "final_time": labelled(phase.final_time, (), "s", "length of the leg"),
        "step": labelled(phase.step, (), "s", "length of an interval"),
        "control_effort": labelled(
            phase.quadratic_effort,
            (),
            "N2 m2 s" if "q_ob" in phase.series else "1",
            "squared effort",
        ),
    }
    for name, error in phase.errors.items():
        unit = _ERROR_UNITS.get(name, "1")
        variables[f"{name}_error"] = labelled(error, (), unit, f"{name} error at its node")
        variables[f"{name}_tolerance"] = labelled(
            phase.tolerances[name], (), unit, f"allowed {name} error"
        )
    for name, cost in phase.objective.items():
        variables[f"objective_{name}"] = labelled(cost, (), "1", f"{name} part of the objective")
    if alternative:
        other = phase if phase.alternative is None else phase.alternative
        held = [name for name in phase.series if not at_nodes(phase, name)]
        key = next((name for name in ("torque_body", "torque_thrusters") if name in held), held[0])
        dims, units, _ = _label(phase, key, own)
        variables[f"alternative_{key}"] = labelled(
            other.series[key], dims, units, "of the best answer that reaches"
        )
    if phase.pointing is not None:
        record = phase.pointing
        variables["cone_angle"] = labelled(
            record.angles, ("fine_time", "cone"), "rad", "angle of boresight and direction"
        )
    return variables | _starts(phase)


def _starts(phase: Phase) -> dict[str, Variable]:
    starts, along = phase.starts, ("start",)
    status = {
        "long_name": "how the start ended",
        "flag_values": np.array([int(status) for status in Status]),
        "flag_meanings": " ".join(status.name.lower() for status in Status),
    }
    labels = {
        "reached": ("", "whether it reached the target, flown again"),
        "active_intervals": ("1", "active intervals"),
        "effort": ("N m s" if "q_ob" in phase.series else "1", "L1 effort"),
        "long_way": ("", "whether it went the long way round"),
        "iterations": ("1", "inner steps"),
        "shortfall": ("1", "largest error in units of its tolerance"),
    }
    variables = {
        f"start_{name}": labelled(getattr(starts, name), along, *words)
        for name, words in labels.items()
        if getattr(starts, name) is not None
    }
    minima = labelled(starts.distinct_minima, (), "1", "different answers among those that reach")
    return variables | {"start_status": (along, starts.status, status), "distinct_minima": minima}


def _attributes(result: Answer, sections: Sections) -> Mapping[str, Any]:
    scenario = result.scenario
    return {
        "scenario": scenario.name,
        "title": scenario.title,
        "source": scenario.source,
        "scenario_document": json.dumps(scenario.document),
        "scenario_folder": "" if scenario.folder is None else str(scenario.folder.resolve()),
        "objective": scenario.objective.kind,
        "terminal": scenario.objective.terminal,
        "status": result.status,
        "obstacle": "; ".join(
            phase.failure_reason for phase in result.phases if phase.failure_reason
        ),
        "seed": result.seed,
        "device": result.device,
        "precision": result.precision,
        "versions": json.dumps(dict(result.versions)),
        "switch_times_s": json.dumps([None] * len(result.phases)),
        "notes": json.dumps(list(result.notes)),
        **{f"time_{name}_s": float(seconds) for name, seconds in result.time.items()},
        **sections.attributes(result),
    }
