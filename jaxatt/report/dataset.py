"""A result as a labelled xarray Dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.answer import Answer
from jaxatt.records.phase import Phase
from jaxatt.records.timeline import node_times
from jaxatt.report.final_times import final_times_variables

if TYPE_CHECKING:
    import xarray

_Variable = tuple[tuple[str, ...], Any, dict[str, Any]]

_SERIES = {
    "q_ob": (("time", "quaternion"), "1", "attitude of the body relative to the orbit frame"),
    "omega_ob": (("time", "axis"), "rad/s", "rate relative to the orbit frame, in body axes"),
    "omega_ib": (("time", "axis"), "rad/s", "rate relative to the inertial frame, in body axes"),
    "omega_bw": (("time", "wheel"), "rad/s", "wheel speed relative to the body"),
    "torque_body": (("interval", "axis"), "N m", "torque on the wheels in body axes"),
    "torque_wheels": (("interval", "wheel"), "N m", "torque on each wheel"),
    "torque_thrusters": (("interval", "thruster"), "N m", "torque of each thruster, relaxed"),
    "state": (("time", "component"), "1", "state"),
    "control": (("interval", "input"), "1", "control"),
}
_REFERENCES = {
    "q_ob": (("quaternion",), "1", "target attitude"),
    "waypoint": (("quaternion",), "1", "attitude to pass"),
    "omega_ob": (("axis",), "rad/s", "target rate relative to the orbit frame"),
    "state": (("component",), "1", "target state"),
}
_ERROR_UNITS = {"attitude": "rad", "rate": "rad/s", "waypoint": "rad", "state": "1"}


def to_dataset(result: Answer) -> xarray.Dataset:
    """Labelled arrays of a result, SI units and radians, with what made them as attributes.

    Dimensions are `time` (nodes, from the phase's start [s]), `interval`, `axis`, `wheel`,
    `quaternion` (scalar first) and `start`, `component` and `input` for a toy; where the case has
    several phases, `leg` comes first everywhere.  Where the phases' intervals differ in length,
    `time` holds node numbers and `node_time` (phase, time) the times.
    """
    import xarray

    alternative = any(phase.alternative is not None for phase in result.phases)
    tried = (phase.final_times for phase in result.phases if phase.final_times is not None)
    trials = max((len(times.how) for times in tried), default=0)
    together = len({phase.step for phase in result.phases}) == 1
    parts = [
        xarray.Dataset(
            _variables(phase, alternative)
            | final_times_variables(phase, trials)
            | ({} if together else _times(phase, "node_time")),
            _coordinates(phase) | (_times(phase) if together else _numbers(phase)),
        )
        for phase in result.phases
    ]
    if len(parts) == 1:
        dataset = parts[0]
    else:
        numbers = xarray.Variable("leg", np.arange(1, len(parts) + 1), {"long_name": "leg"})
        dataset = xarray.concat(parts, dim="leg", data_vars="all", coords="minimal", join="exact")
        dataset = dataset.assign_coords(leg=numbers)
    return dataset.assign_attrs(_attributes(result))


def _coordinates(phase: Phase) -> dict[str, _Variable]:
    times, count = node_times(phase), len(phase.active)
    coordinates: dict[str, _Variable] = {
        "coasting": (
            ("time",),
            times > phase.step * (count + 0.5),
            {"long_name": "whether the horizon has ended"},
        ),
        "interval": (("interval",), np.arange(count), {"long_name": "control interval"}),
        "start": (("start",), np.arange(len(phase.starts.status)), {"long_name": "start"}),
    }
    if phase.pointing is not None:
        cones = [e for e in phase.pointing.extremes if e.kind != "body-rate"]
        words = {"units": "s", "long_name": "every Runge-Kutta step, from the leg's start"}
        coordinates["fine_time"] = (("fine_time",), phase.pointing.time, words)
        coordinates["cone"] = (("cone",), [e.name for e in cones], {"long_name": "cone"})
        coordinates["cone_kind"] = (("cone",), [e.kind for e in cones], {"long_name": "kind"})
        coordinates["cone_half_angle"] = (
            ("cone",),
            [e.allowed for e in cones],
            {"units": "rad", "long_name": "half angle"},
        )
    if "q_ob" in phase.series:
        wheels = phase.series["omega_bw"].shape[1]
        coordinates["axis"] = (("axis",), ["x", "y", "z"], {"long_name": "body axis"})
        coordinates["wheel"] = (("wheel",), np.arange(1, wheels + 1), {"long_name": "wheel"})
        if "torque_thrusters" in phase.series:
            count = phase.series["torque_thrusters"].shape[1]
            words = {"long_name": "thruster"}
            coordinates["thruster"] = (("thruster",), np.arange(1, count + 1), words)
        coordinates["quaternion"] = (
            ("quaternion",),
            ["w", "x", "y", "z"],
            {"long_name": "quaternion component, scalar first"},
        )
    else:
        components = [f"x{i + 1}" for i in range(phase.series["state"].shape[1])]
        coordinates["component"] = (("component",), components, {"long_name": "state component"})
    return coordinates


def _times(phase: Phase, nodes: str = "time") -> dict[str, _Variable]:
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


def _numbers(phase: Phase) -> dict[str, _Variable]:
    """Numbers of the nodes, where their times differ from phase to phase."""
    return {"time": (("time",), np.arange(len(node_times(phase))), {"long_name": "node"})}


def _variables(phase: Phase, alternative: bool) -> dict[str, _Variable]:
    variables = {
        name: _labelled(phase.series[name], *_SERIES[name])
        for name in _SERIES
        if name in phase.series
    }
    for name, labels in _REFERENCES.items():
        if name in phase.reference:
            key = name if name == "waypoint" else f"{name}_reference"
            variables[key] = _labelled(phase.reference[name], *labels)
    variables |= {
        "weight": _labelled(phase.weight, ("interval",), "1", "cost of the interval if active"),
        "window": _labelled(phase.window, ("interval",), "", "whether in a cheap window"),
        "forbidden": _labelled(phase.forbidden, ("interval",), "", "whether torque is forbidden"),
        "active": _labelled(phase.active, ("interval",), "", "whether above the threshold"),
        "leg_start": _labelled(phase.start_time, (), "s", "time at which the leg starts"),
        "reached": _labelled(phase.reached, (), "", "whether the flight is within all tolerances"),
        "effort": _labelled(
            phase.effort, (), "N m s" if "q_ob" in phase.series else "1", "L1 effort over all axes"
        ),
    }
    for name, error in phase.errors.items():
        unit = _ERROR_UNITS.get(name, "1")
        variables[f"{name}_error"] = _labelled(error, (), unit, f"{name} error at its node")
        variables[f"{name}_tolerance"] = _labelled(
            phase.tolerances[name], (), unit, f"allowed {name} error"
        )
    for name, cost in phase.objective.items():
        variables[f"objective_{name}"] = _labelled(cost, (), "1", f"{name} part of the objective")
    if alternative:
        other = phase if phase.alternative is None else phase.alternative
        known = ("torque_body", "torque_thrusters", "control")
        key = next(name for name in known if name in phase.series)
        variables[f"alternative_{key}"] = _labelled(
            other.series[key], _SERIES[key][0], _SERIES[key][1], "of the best answer that reaches"
        )
    for valves in phase.quantised[:1]:
        flown: dict[str, tuple[Any, tuple[str, ...], str, str]] = {
            "opens": (valves.opens, ("interval", "thruster"), "s", "opening after its start"),
            "shuts": (valves.shuts, ("interval", "thruster"), "s", "shutting after its start"),
            "q_ob": (valves.q_ob, ("time", "quaternion"), "1", "attitude with valves"),
            "omega_ob": (valves.omega_ob, ("time", "axis"), "rad/s", "rate with valves"),
            "attitude_error": (valves.errors["attitude"], (), "rad", "attitude error with valves"),
            "rate_error": (valves.errors["rate"], (), "rad/s", "rate error with valves"),
        }
        variables |= {f"quantised_{name}": _labelled(*rest) for name, rest in flown.items()}
    if phase.pointing is not None:
        record = phase.pointing
        variables["cone_angle"] = _labelled(
            record.angles, ("fine_time", "cone"), "rad", "angle of boresight and direction"
        )
    return variables | _starts(phase) | _time_optimum(phase)


def _starts(phase: Phase) -> dict[str, _Variable]:
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
        f"start_{name}": _labelled(getattr(starts, name), along, *words)
        for name, words in labels.items()
    }
    minima = _labelled(starts.distinct_minima, (), "1", "different answers among those that reach")
    return variables | {"start_status": (along, starts.status, status), "distinct_minima": minima}


def _time_optimum(phase: Phase) -> dict[str, _Variable]:
    variables = {
        "final_time": _labelled(phase.final_time, (), "s", "length of the leg"),
        "step": _labelled(phase.step, (), "s", "length of an interval"),
        "control_effort": _labelled(
            phase.control_effort, (), "N2 m2 s" if "q_ob" in phase.series else "1", "squared effort"
        ),
    }
    optimum = phase.time_optimum
    if optimum is None:
        return variables
    return variables | {
        "start_cost": _labelled(optimum.start_costs, ("start",), "s", "cost at the end"),
        "start_final_time": _labelled(optimum.start_times, ("start",), "s", "final time"),
        "cost": _labelled(optimum.cost, (), "s", "time and weighted effort"),
        "kkt_violation": _labelled(optimum.violation, (), "1", "largest violation"),
        "kkt_stationarity": _labelled(optimum.stationarity, (), "1", "Lagrangian's gradient"),
        "share_at_best": _labelled(optimum.share, (), "1", "share of starts at the best minimum"),
        "own_error": _labelled(
            optimum.own_error, (), "rad", "attitude error where the transcription ends"
        ),
    }


def _labelled(values: Any, dims: tuple[str, ...], units: str, words: str) -> _Variable:
    return dims, np.asarray(values), {"long_name": words} | ({"units": units} if units else {})


def _attributes(result: Answer) -> Mapping[str, Any]:
    scenario = result.scenario
    return {
        "scenario": scenario.name,
        "title": scenario.title,
        "source": scenario.source,
        "scenario_document": json.dumps(scenario.document),
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
        "switch_times_s": json.dumps(
            [
                None
                if phase.time_optimum is None
                else phase.time_optimum.to_dict()["switch_times_s"]
                for phase in result.phases
            ]
        ),
        "notes": json.dumps(list(result.notes)),
        **{f"time_{name}_s": float(seconds) for name, seconds in result.time.items()},
    }
