"""Conversion of a simulation to a labelled xarray Dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from jaxatt.report.flight_record import ENDINGS, FlightRecord
from jaxatt.report.flight_summary import AXES
from jaxatt.report.wheel_coordinates import wheel_coordinates
from jaxatt.simulation.settling import CHANNELS

if TYPE_CHECKING:
    import xarray

_SERIES = {
    "q_ob": ("quaternion", "1", "attitude of the body relative to the frame of reference"),
    "error": ("axis", "1", "vector part of the error quaternion, eta >= 0"),
    "rate_error": ("axis", "rad/s", "rate minus its reference, in body axes"),
    "omega_ob": ("axis", "rad/s", "rate relative to the frame of reference, in body axes"),
    "omega_bw": ("wheel", "rad/s", "wheel speed relative to the body"),
    "wheel_torque": ("wheel", "N m", "torque on each wheel, held over the sample"),
    "dipole": ("axis", "A m2", "magnetorquers' dipole in body axes"),
}


def flight_dataset(result: FlightRecord) -> xarray.Dataset:
    """Dataset with dimensions run, time (records [s]), axis, wheel, quaternion and channel."""
    import xarray

    unit = "rad" if result.scenario.signal == "attitude" else "rad/s"
    flown = result.flown
    series = {
        name: (
            ("run", "time", inner),
            np.asarray(getattr(flown.recorded, name)),
            {"units": unit_, "long_name": words},
        )
        for name, (inner, unit_, words) in _SERIES.items()
    }
    figures = {
        "settling": (
            ("run", "channel"),
            np.asarray(flown.figures.settling),
            {"units": "s", "long_name": "settling time, nan where it never settles"},
        ),
        "rms": (("run", "channel"), np.asarray(flown.figures.rms), {"units": unit}),
        "final": (("run", "channel"), np.asarray(flown.figures.final), {"units": unit}),
        "integral": (
            "run",
            np.asarray(flown.figures.integral),
            {"units": "N m s", "long_name": "integral of the torque's Euclidean norm"},
        ),
        "peak": (
            ("run", "axis"),
            np.asarray(flown.figures.peak),
            {"units": "N m", "long_name": "largest torque on the body"},
        ),
        "saturated": (
            "run",
            np.asarray(flown.figures.saturated),
            {"units": "1", "long_name": "share of the time in which a dipole is at its limit"},
        ),
        "ending": (
            "run",
            np.asarray(flown.what),
            {"values": "; ".join(f"{code} {words}" for code, words in ENDINGS.items())},
        ),
        "ended": ("run", np.asarray(flown.ended), {"units": "s", "long_name": "time of failure"}),
        "reference": (("time", "quaternion"), result.reference, {"units": "1"}),
    }
    return xarray.Dataset(
        {**series, **figures},
        coords={
            "run": np.arange(result.runs),
            "time": ("time", result.record_times, {"units": "s"}),
            "axis": list(AXES),
            "quaternion": ["eta", "eps_x", "eps_y", "eps_z"],
            **wheel_coordinates(result.scenario.vehicle.wheels),
            "channel": list(CHANNELS),
        },
        attrs={
            "scenario": result.scenario.name,
            "title": result.scenario.title,
            "source": result.scenario.source,
            "law": result.law,
            "seed": result.seed,
            "spread": "" if result.spread is None else str(result.spread),
            "device": result.device,
            "versions": json.dumps(dict(result.versions)),
            "document": json.dumps(result.scenario.document),
            "scenario_folder": ""
            if result.scenario.folder is None
            else str(result.scenario.folder.resolve()),
        },
    )
