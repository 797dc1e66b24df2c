"""A result as a labelled xarray Dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.report.final_times import final_times_variables
from jaxatt.report.result import Leg, Result
from jaxatt.report.timeline import node_times

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


def to_dataset(result: Result) -> xarray.Dataset:
    """Labelled arrays of a result, SI units and radians, with what made them as attributes.

    Dimensions are `time` (nodes, from the leg's start [s]), `interval`, `axis`, `wheel`,
    `quaternion` (scalar first) and `start`, `component` and `input` for a toy; where the case has
    several legs, `leg` comes first everywhere.  Where the legs' intervals differ in length, `time`
    holds node numbers and `node_time` (leg, time) the times.
    """
    import xarray

    alternative = any(leg.alternative is not None for leg in result.legs)
    tried = (leg.final_times for leg in result.legs if leg.final_times is not None)
    trials = max((len(times.how) for times in tried), default=0)
    together = len({leg.step for leg in result.legs}) == 1
    parts = [
        xarray.Dataset(
            _variables(leg, alternative)
            | final_times_variables(leg, trials)
            | ({} if together else _times(leg, "node_time")),
            _coordinates(leg) | (_times(leg) if together else _numbers(leg)),
        )
        for leg in result.legs
    ]
    if len(parts) == 1:
        dataset = parts[0]
    else:
        numbers = xarray.Variable("leg", np.arange(1, len(parts) + 1), {"long_name": "leg"})
        dataset = xarray.concat(parts, dim="leg", data_vars="all", coords="minimal", join="exact")
        dataset = dataset.assign_coords(leg=numbers)
    return dataset.assign_attrs(_attributes(result))


def _coordinates(leg: Leg) -> dict[str, _Variable]:
    times, count = node_times(leg), len(leg.active)
    coordinates: dict[str, _Variable] = {
        "coasting": (
            ("time",),
            times > leg.step * (count + 0.5),
            {"long_name": "whether the horizon has ended"},
        ),
        "interval": (("interval",), np.arange(count), {"long_name": "control interval"}),
        "start": (("start",), np.arange(len(leg.starts.status)), {"long_name": "start"}),
    }
    if leg.pointing is not None:
        cones = [e for e in leg.pointing.extremes if e.kind != "body-rate"]
        words = {"units": "s", "long_name": "every Runge-Kutta step, from the leg's start"}
        coordinates["fine_time"] = (("fine_time",), leg.pointing.time, words)
        coordinates["cone"] = (("cone",), [e.name for e in cones], {"long_name": "cone"})
        coordinates["cone_kind"] = (("cone",), [e.kind for e in cones], {"long_name": "kind"})
        coordinates["cone_half_angle"] = (
            ("cone",),
            [e.allowed for e in cones],
            {"units": "rad", "long_name": "half angle"},
        )
    if "q_ob" in leg.series:
        wheels = leg.series["omega_bw"].shape[1]
        coordinates["axis"] = (("axis",), ["x", "y", "z"], {"long_name": "body axis"})
        coordinates["wheel"] = (("wheel",), np.arange(1, wheels + 1), {"long_name": "wheel"})
        if "torque_thrusters" in leg.series:
            count = leg.series["torque_thrusters"].shape[1]
            words = {"long_name": "thruster"}
            coordinates["thruster"] = (("thruster",), np.arange(1, count + 1), words)
        coordinates["quaternion"] = (
            ("quaternion",),
            ["w", "x", "y", "z"],
            {"long_name": "quaternion component, scalar first"},
        )
    else:
        components = [f"x{i + 1}" for i in range(leg.series["state"].shape[1])]
        coordinates["component"] = (("component",), components, {"long_name": "state component"})
    return coordinates


def _times(leg: Leg, nodes: str = "time") -> dict[str, _Variable]:
    """Times of nodes and intervals from the leg's start."""
    return {
        nodes: (
            ("time",),
            node_times(leg),
            {"units": "s", "long_name": "time from the leg's start"},
        ),
        "interval_start": (
            ("interval",),
            leg.step * np.arange(len(leg.active)),
            {"units": "s", "long_name": "start of the interval from the leg's start"},
        ),
    }


def _numbers(leg: Leg) -> dict[str, _Variable]:
    """Numbers of the nodes, where their times differ from leg to leg."""
    return {"time": (("time",), np.arange(len(node_times(leg))), {"long_name": "node"})}


def _variables(leg: Leg, alternative: bool) -> dict[str, _Variable]:
    variables = {
        name: _labelled(leg.series[name], *_SERIES[name]) for name in _SERIES if name in leg.series
    }
    for name, labels in _REFERENCES.items():
        if name in leg.reference:
            key = name if name == "waypoint" else f"{name}_reference"
            variables[key] = _labelled(leg.reference[name], *labels)
    variables |= {
        "weight": _labelled(leg.weight, ("interval",), "1", "cost of the interval if active"),
        "window": _labelled(leg.window, ("interval",), "", "whether in a cheap window"),
        "forbidden": _labelled(leg.forbidden, ("interval",), "", "whether torque is forbidden"),
        "active": _labelled(leg.active, ("interval",), "", "whether above the threshold"),
        "leg_start": _labelled(leg.start_time, (), "s", "time at which the leg starts"),
        "reached": _labelled(leg.reached, (), "", "whether the flight is within all tolerances"),
        "effort": _labelled(
            leg.effort, (), "N m s" if "q_ob" in leg.series else "1", "L1 effort over all axes"
        ),
    }
    for name, error in leg.errors.items():
        unit = _ERROR_UNITS.get(name, "1")
        variables[f"{name}_error"] = _labelled(error, (), unit, f"{name} error at its node")
        variables[f"{name}_tolerance"] = _labelled(
            leg.tolerances[name], (), unit, f"allowed {name} error"
        )
    for name, cost in leg.objective.items():
        variables[f"objective_{name}"] = _labelled(cost, (), "1", f"{name} part of the objective")
    if alternative:
        other = leg if leg.alternative is None else leg.alternative
        known = ("torque_body", "torque_thrusters", "control")
        key = next(name for name in known if name in leg.series)
        variables[f"alternative_{key}"] = _labelled(
            other.series[key], _SERIES[key][0], _SERIES[key][1], "of the best answer that reaches"
        )
    for valves in leg.quantised[:1]:
        flown: dict[str, tuple[Any, tuple[str, ...], str, str]] = {
            "opens": (valves.opens, ("interval", "thruster"), "s", "opening after its start"),
            "shuts": (valves.shuts, ("interval", "thruster"), "s", "shutting after its start"),
            "q_ob": (valves.q_ob, ("time", "quaternion"), "1", "attitude with valves"),
            "omega_ob": (valves.omega_ob, ("time", "axis"), "rad/s", "rate with valves"),
            "attitude_error": (valves.errors["attitude"], (), "rad", "attitude error with valves"),
            "rate_error": (valves.errors["rate"], (), "rad/s", "rate error with valves"),
        }
        variables |= {f"quantised_{name}": _labelled(*rest) for name, rest in flown.items()}
    if leg.pointing is not None:
        record = leg.pointing
        variables["cone_angle"] = _labelled(
            record.angles, ("fine_time", "cone"), "rad", "angle of boresight and direction"
        )
    return variables | _starts(leg) | _time_optimum(leg)


def _starts(leg: Leg) -> dict[str, _Variable]:
    starts, along = leg.starts, ("start",)
    status = {
        "long_name": "how the start ended",
        "flag_values": np.array([int(status) for status in Status]),
        "flag_meanings": " ".join(status.name.lower() for status in Status),
    }
    labels = {
        "reached": ("", "whether it reached the target, flown again"),
        "active_intervals": ("1", "active intervals"),
        "effort": ("N m s" if "q_ob" in leg.series else "1", "L1 effort"),
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


def _time_optimum(leg: Leg) -> dict[str, _Variable]:
    variables = {
        "final_time": _labelled(leg.final_time, (), "s", "length of the leg"),
        "step": _labelled(leg.step, (), "s", "length of an interval"),
        "control_effort": _labelled(
            leg.control_effort, (), "N2 m2 s" if "q_ob" in leg.series else "1", "squared effort"
        ),
    }
    optimum = leg.time_optimum
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


def _attributes(result: Result) -> Mapping[str, Any]:
    scenario = result.scenario
    return {
        "scenario": scenario.name,
        "title": scenario.title,
        "source": scenario.source,
        "scenario_document": json.dumps(scenario.document),
        "objective": scenario.objective.kind,
        "terminal": scenario.objective.terminal,
        "status": result.status,
        "obstacle": "; ".join(leg.obstacle for leg in result.legs if leg.obstacle),
        "seed": result.seed,
        "device": result.device,
        "precision": result.precision,
        "versions": json.dumps(dict(result.versions)),
        "switch_times_s": json.dumps(
            [
                None if leg.time_optimum is None else leg.time_optimum.to_dict()["switch_times_s"]
                for leg in result.legs
            ]
        ),
        "notes": json.dumps(list(result.notes)),
        **{f"time_{name}_s": float(seconds) for name, seconds in result.time.items()},
    }
