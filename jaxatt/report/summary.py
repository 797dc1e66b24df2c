"""A result in plain numbers under stable names, as `summary.json` holds it.

Where a case has several legs, the top level adds up costs, counts, efforts, times, starts, shifts
the interval indices of leg k (counted from zero) by k N, and takes errors and violations from the
worst leg; `step_s` is null where the legs' intervals differ in length.  A name that does not apply
holds null.  For the toy systems the names with N m hold values in the unit of their control.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.report.files import replacing
from jaxatt.report.final_times import final_times_summary
from jaxatt.report.result import Leg, Result, StartsRecord, Valves
from jaxatt.report.wording import LIMITS

_ERRORS = {
    "attitude_error_deg": ("attitude", math.degrees(1.0)),
    "rate_error_rad_s": ("rate", 1.0),
    "waypoint_error_deg": ("waypoint", math.degrees(1.0)),
    "state_error": ("state", 1.0),
}
"""Name in the summary -> (name in `Leg.errors`, factor to its unit)."""

_SUMS = (
    "active_intervals",
    "weighted_active_intervals",
    "active_outside_windows",
    "l1_effort_Nms",
    "final_time_s",
    "control_effort",
)
_WORST = (*_ERRORS, "max_torque_violation_Nm", "max_complementarity_Nm")


def summary(result: Result) -> dict[str, Any]:
    """Plain numbers, texts and lists of a result, ready for JSON (no NaN, no arrays)."""
    legs = [_leg(leg) for leg in result.legs]
    several = len(legs) > 1
    body = _together(legs, result.scenario.horizon.intervals) if several else legs[0]
    alternative = None if several else result.legs[0].alternative
    numbered = [
        {
            "leg": index + 1,
            "start_time_s": leg.start_time,
            **block,
            "alternative": None if leg.alternative is None else _leg(leg.alternative),
        }
        for index, (leg, block) in enumerate(zip(result.legs, legs, strict=True))
    ]
    numbers: dict[str, Any] = _clean(
        {
            "scenario": result.scenario.name,
            **body,
            "do_nothing_cost": do_nothing_cost(result),
            "alternative": None if alternative is None else _leg(alternative),
            "quantised_otherwise": _other_way(result.legs) if not several else None,
            "legs": numbered if several else [],
            "time_s": {name: result.time.get(name) for name in ("compile", "solve", "verify")},
            "seed": result.seed,
            "device": result.device,
            "precision": result.precision,
            "versions": dict(result.versions),
            "notes": list(result.notes),
        }
    )
    return numbers


def write_summary(result: Result, path: str | Path) -> None:
    """Write the summary as a JSON file."""
    write_json(summary(result), path)


def write_json(content: Mapping[str, Any], path: str | Path) -> None:
    """Write a mapping as a JSON file, whole or not at all."""
    with replacing(path) as partial:
        partial.write_text(json.dumps(_clean(content), indent=2) + "\n", encoding="utf-8")


def do_nothing_cost(result: Result) -> float | None:
    """The printed cost of applying no torque at all, where it is known."""
    known = result.extra.get("do_nothing_cost")
    if known is not None:
        return float(known)
    resting = not any(leg.active.any() for leg in result.legs)
    return sum(leg.total_cost for leg in result.legs) if resting else None


def starts_summary(starts: StartsRecord) -> dict[str, int]:
    """How many starts were made, converged and reached, and how many answers differ."""
    return {
        "requested": len(starts.status),
        "converged": int((starts.status == int(Status.CONVERGED)).sum()),
        "reached_target": int(starts.reached.sum()),
        "distinct_minima": starts.distinct_minima,
    }


def _leg(leg: Leg) -> dict[str, Any]:
    errors = {
        name: leg.errors[key] * factor if key in leg.errors else None
        for name, (key, factor) in _ERRORS.items()
    }
    optimum = leg.time_optimum
    return {
        "status": "reached" if leg.reached else "not reached",
        "objective": {"total": leg.total_cost, **leg.objective},
        "active_intervals": leg.active_intervals,
        "active_interval_indices": np.flatnonzero(leg.active).tolist(),
        "weighted_active_intervals": leg.weighted_active_intervals,
        "active_outside_windows": leg.active_outside_windows,
        "relative_sparsity_percent": 100.0 * leg.active_intervals / len(leg.active),
        **errors,
        "max_torque_violation_Nm": leg.limit_violation,
        "max_complementarity_Nm": leg.max_complementarity,
        "l1_effort_Nms": leg.effort,
        "final_time_s": leg.final_time,
        "step_s": leg.step,
        "control_effort": leg.control_effort,
        "cost": None if optimum is None else optimum.cost,
        "kkt": None if optimum is None else optimum.kkt,
        "time_optimum": None if optimum is None else optimum.to_dict(),
        "final_times": final_times_summary(leg.final_times),
        "quantised": valves_summary(leg.quantised[0]) if leg.quantised else None,
        "pointing": _pointing(leg),
        "obstacle": leg.obstacle,
        "starts": starts_summary(leg.starts),
    }


def valves_summary(valves: Valves) -> dict[str, Any]:
    """An answer with thrusters open or shut in plain numbers; `on_time_s` by thruster."""
    active = int(valves.active.sum())
    return {
        "mode": valves.mode,
        "status": "reached" if valves.reached else "not reached",
        "active_intervals": active,
        "relative_sparsity_percent": 100.0 * active / len(valves.active),
        "attitude_error_deg": math.degrees(valves.errors["attitude"]),
        "rate_error_rad_s": valves.errors["rate"],
        "on_time_s": valves.on_time.tolist(),
        "partially_open_samples": valves.partly_open,
        "opposed_firings": valves.opposed,
        "obstacle": valves.obstacle,
    }


def _pointing(leg: Leg) -> list[dict[str, Any]]:
    """Every cone and limited rate at its worst instant; `time_s` from the leg's start."""
    found = []
    for e in () if leg.pointing is None else leg.pointing.extremes:
        name, unit = LIMITS[e.kind]
        found.append(
            {
                "name": e.name,
                "kind": e.kind,
                f"{name}_{unit}": math.degrees(e.value),
                f"allowed_{unit}": math.degrees(e.allowed),
                "time_s": e.time,
                "satisfied": e.satisfied,
            }
        )
    return found


def _other_way(legs: Sequence[Leg]) -> dict[str, Any] | None:
    """The way of quantising that the scenario did not ask for, of a single leg."""
    others = legs[0].quantised[1:]
    return valves_summary(others[0]) if others else None


def _valves_together(legs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    reached = all(leg["status"] == "reached" for leg in legs)
    return {
        "mode": legs[0]["mode"],
        "status": "reached" if reached else "not reached",
        "active_intervals": sum(leg["active_intervals"] for leg in legs),
        "relative_sparsity_percent": float(
            np.mean([leg["relative_sparsity_percent"] for leg in legs])
        ),
        "attitude_error_deg": float(np.max([leg["attitude_error_deg"] for leg in legs])),
        "rate_error_rad_s": float(np.max([leg["rate_error_rad_s"] for leg in legs])),
        "on_time_s": np.sum([leg["on_time_s"] for leg in legs], axis=0).tolist(),
        "partially_open_samples": sum(leg["partially_open_samples"] for leg in legs),
        "opposed_firings": sum(leg["opposed_firings"] for leg in legs),
        "obstacle": "; ".join(leg["obstacle"] for leg in legs if leg["obstacle"]),
    }


def _together(legs: Sequence[Mapping[str, Any]], intervals: int) -> dict[str, Any]:
    together: dict[str, Any] = {name: sum(leg[name] for leg in legs) for name in _SUMS}
    for name in _WORST:
        values = [leg[name] for leg in legs if leg[name] is not None]
        # max() would pass over a NaN, which is the worst of all.
        together[name] = float(np.max(values)) if values else None
    for name in ("objective", "starts"):
        together[name] = {part: sum(leg[name][part] for leg in legs) for part in legs[0][name]}
    together["active_interval_indices"] = [
        index + number * intervals
        for number, leg in enumerate(legs)
        for index in leg["active_interval_indices"]
    ]
    together["pointing"] = [
        {"leg": number + 1, **entry} for number, leg in enumerate(legs) for entry in leg["pointing"]
    ]
    steps = {leg["step_s"] for leg in legs}
    together["step_s"] = steps.pop() if len(steps) == 1 else None
    together |= dict.fromkeys(("cost", "kkt", "time_optimum", "final_times"))
    valves = [leg["quantised"] for leg in legs]
    together["quantised"] = None if None in valves else _valves_together(valves)
    count = together["active_intervals"]
    reached = all(leg["status"] == "reached" for leg in legs)
    together["status"] = "reached" if reached else "not reached"
    together["relative_sparsity_percent"] = 100.0 * count / (intervals * len(legs))
    together["obstacle"] = "; ".join(
        f"leg {number + 1}: {leg['obstacle']}" for number, leg in enumerate(legs) if leg["obstacle"]
    )
    return {name: together[name] for name in legs[0]}


def _clean(value: Any) -> Any:
    """Return plain Python for JSON; numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {str(key): _clean(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_clean(item) for item in value]
    if hasattr(value, "tolist"):
        return _clean(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
