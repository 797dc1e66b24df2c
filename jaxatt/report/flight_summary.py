"""A simulation as plain numbers under stable names."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from jaxatt.report.flight_record import PERCENTILES, FlightRecord
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.settling import CHANNELS

AXES = CHANNELS[:3]


def units(result: FlightRecord) -> tuple[str, float]:
    """Unit in which errors are shown, and the factor to it."""
    return ("deg", math.degrees(1.0)) if result.scenario.signal == "attitude" else ("rad_s", 1.0)


def flight_summary(result: FlightRecord) -> dict[str, Any]:
    """Percentiles over the runs that flew to the end, and the number of failures by cause."""
    unit, factor = units(result)
    error = result.flight_error
    settling = result.figure("settling")
    rms, final = factor * result.figure("rms"), factor * np.abs(result.figure("final"))
    peak = result.figure("peak")
    if result.runs > 1:
        peak = np.abs(peak)  # its sign changes from run to run: percentiles are of its size
    found: dict[str, Any] = {
        "scenario": result.scenario.name,
        "law": result.law,
        "title": result.scenario.law_titles.get(result.law, result.law),
        "runs": result.runs,
        "settled": int(result.settled.sum()),
        "not_settled": int((result.sound & ~result.settled).sum()),
        "failed": {
            words: {
                "count": len(rows),
                "runs": rows,
                "times_s": np.asarray(result.flown.ended)[rows].tolist(),
            }
            for words, rows in result.failures.items()
        },
        "settling_s": {axis: _percentiles(settling[:, i]) for i, axis in enumerate(CHANNELS)},
        "settling_worst_s": _percentiles(result.figure("settling_worst")),
        f"rms_{unit}": {axis: _percentiles(rms[:, i]) for i, axis in enumerate(CHANNELS)},
        f"final_{unit}": {axis: _percentiles(final[:, i]) for i, axis in enumerate(CHANNELS)},
        "integral_Nms": _percentiles(result.figure("integral")),
        "dipole_saturated_percent": None
        if result.scenario.dumping is None
        else _percentiles(100.0 * result.figure("saturated")),
        "peak_Nm": {axis: _percentiles(peak[:, i]) for i, axis in enumerate(AXES)},
        "band_stays_s": {name: _percentiles(stay) for name, stay in result.band_stays.items()},
        "flight_error_deg": None if error is None else math.degrees(error.attitude),
        "flight_error_rad_s": None if error is None else error.rate,
        "spread": None if result.spread is None else asdict(result.spread),
        "seed": result.seed,
        "time_s": dict(result.time),
        "device": result.device,
        "versions": dict(result.versions),
        "notes": [*result.scenario.notes, *result.notes],
    }
    return found


def _percentiles(values: Floats) -> dict[str, float | int | None]:
    """Percentiles of the finite values, and the number of runs that never settle."""
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return {"count": 0}
    levels = np.percentile(finite, PERCENTILES)
    named: dict[str, float | int | None] = {
        f"p{level:g}": float(value) for level, value in zip(PERCENTILES, levels, strict=True)
    }
    return {"count": len(finite), "mean": float(finite.mean()), **named}
