"""A result in plain numbers under stable names, as `summary.json` holds it.

Where a case has several phases, the top level adds up costs, counts, efforts, times, starts, shifts
the interval indices of phase k (counted from zero) by k N, and takes errors and violations from the
worst phase; `step_s` is null where the phases' intervals differ in length.  A name that does not
apply holds null.  For the toy systems the names with N m hold values in the unit of their control.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.optimize.status import Status
from jaxatt.problems.answer import Answer
from jaxatt.records.phase import Phase
from jaxatt.records.starts import StartsRecord
from jaxatt.records.valves import Valves
from jaxatt.records.wording import LIMITS
from jaxatt.report.final_times import final_times_summary
from jaxatt.runtime.json_files import plain, write_json

_ERRORS = {
    "attitude_error_deg": ("attitude", math.degrees(1.0)),
    "rate_error_rad_s": ("rate", 1.0),
    "waypoint_error_deg": ("waypoint", math.degrees(1.0)),
    "state_error": ("state", 1.0),
}
"""Name in the summary -> (name in `Phase.errors`, factor to its unit)."""

_SUMS = (
    "active_intervals",
    "weighted_active_intervals",
    "active_outside_windows",
    "l1_effort_Nms",
    "final_time_s",
    "control_effort",
)
_WORST = (*_ERRORS, "max_torque_violation_Nm", "max_complementarity_Nm")


def summary(result: Answer) -> dict[str, Any]:
    """Plain numbers, texts and lists of a result, ready for JSON (no NaN, no arrays)."""
    phases = [_phase(phase) for phase in result.phases]
    several = len(phases) > 1
    body = _together(phases, result.scenario.horizon.intervals) if several else phases[0]
    alternative = None if several else result.phases[0].alternative
    numbered = [
        {
            "leg": index + 1,
            "start_time_s": phase.start_time,
            **block,
            "alternative": None if phase.alternative is None else _phase(phase.alternative),
        }
        for index, (phase, block) in enumerate(zip(result.phases, phases, strict=True))
    ]
    numbers: dict[str, Any] = plain(
        {
            "scenario": result.scenario.name,
            **body,
            "do_nothing_cost": do_nothing_cost(result),
            "alternative": None if alternative is None else _phase(alternative),
            "quantised_otherwise": _other_way(result.phases) if not several else None,
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


def write_summary(result: Answer, path: str | Path) -> None:
    """Write the summary as a JSON file."""
    write_json(summary(result), path)


def do_nothing_cost(result: Answer) -> float | None:
    """The printed cost of applying no torque at all, where it is known."""
    known = result.extra.get("do_nothing_cost")
    if known is not None:
        return float(known)
    resting = not any(phase.active.any() for phase in result.phases)
    return sum(phase.total_cost for phase in result.phases) if resting else None


def starts_summary(starts: StartsRecord) -> dict[str, int]:
    """How many starts were made, converged and reached, and how many answers differ."""
    return {
        "requested": len(starts.status),
        "converged": int((starts.status == int(Status.CONVERGED)).sum()),
        "reached_target": int(starts.reached.sum()),
        "distinct_minima": starts.distinct_minima,
    }


def _phase(phase: Phase) -> dict[str, Any]:
    errors = {
        name: phase.errors[key] * factor if key in phase.errors else None
        for name, (key, factor) in _ERRORS.items()
    }
    optimum = phase.time_optimum
    return {
        "status": "reached" if phase.reached else "not reached",
        "objective": {"total": phase.total_cost, **phase.objective},
        "active_intervals": phase.active_intervals,
        "active_interval_indices": np.flatnonzero(phase.active).tolist(),
        "weighted_active_intervals": phase.weighted_active_intervals,
        "active_outside_windows": phase.active_outside_windows,
        "relative_sparsity_percent": 100.0 * phase.active_intervals / len(phase.active),
        **errors,
        "max_torque_violation_Nm": phase.limit_violation,
        "max_complementarity_Nm": phase.max_complementarity,
        "l1_effort_Nms": phase.effort,
        "final_time_s": phase.final_time,
        "step_s": phase.step,
        "control_effort": phase.control_effort,
        "cost": None if optimum is None else optimum.cost,
        "kkt": None if optimum is None else optimum.kkt,
        "time_optimum": None if optimum is None else optimum.to_dict(),
        "final_times": final_times_summary(phase.final_times),
        "quantised": valves_summary(phase.quantised[0]) if phase.quantised else None,
        "pointing": _pointing(phase),
        "obstacle": phase.failure_reason,
        "starts": starts_summary(phase.starts),
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
        "obstacle": valves.failure_reason,
    }


def _pointing(phase: Phase) -> list[dict[str, Any]]:
    """Every cone and limited rate at its worst instant; `time_s` from the phase's start."""
    found = []
    for e in () if phase.pointing is None else phase.pointing.extremes:
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


def _other_way(phases: Sequence[Phase]) -> dict[str, Any] | None:
    """The way of quantising that the scenario did not ask for, of a single phase."""
    others = phases[0].quantised[1:]
    return valves_summary(others[0]) if others else None


def _valves_together(phases: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    reached = all(phase["status"] == "reached" for phase in phases)
    return {
        "mode": phases[0]["mode"],
        "status": "reached" if reached else "not reached",
        "active_intervals": sum(phase["active_intervals"] for phase in phases),
        "relative_sparsity_percent": float(
            np.mean([phase["relative_sparsity_percent"] for phase in phases])
        ),
        "attitude_error_deg": float(np.max([phase["attitude_error_deg"] for phase in phases])),
        "rate_error_rad_s": float(np.max([phase["rate_error_rad_s"] for phase in phases])),
        "on_time_s": np.sum([phase["on_time_s"] for phase in phases], axis=0).tolist(),
        "partially_open_samples": sum(phase["partially_open_samples"] for phase in phases),
        "opposed_firings": sum(phase["opposed_firings"] for phase in phases),
        "obstacle": "; ".join(phase["obstacle"] for phase in phases if phase["obstacle"]),
    }


def _together(phases: Sequence[Mapping[str, Any]], intervals: int) -> dict[str, Any]:
    together: dict[str, Any] = {name: sum(phase[name] for phase in phases) for name in _SUMS}
    for name in _WORST:
        values = [phase[name] for phase in phases if phase[name] is not None]
        # max() would pass over a NaN, which is the worst of all.
        together[name] = float(np.max(values)) if values else None
    for name in ("objective", "starts"):
        together[name] = {
            part: sum(phase[name][part] for phase in phases) for part in phases[0][name]
        }
    together["active_interval_indices"] = [
        index + number * intervals
        for number, phase in enumerate(phases)
        for index in phase["active_interval_indices"]
    ]
    together["pointing"] = [
        {"leg": number + 1, **entry}
        for number, phase in enumerate(phases)
        for entry in phase["pointing"]
    ]
    steps = {phase["step_s"] for phase in phases}
    together["step_s"] = steps.pop() if len(steps) == 1 else None
    together |= dict.fromkeys(("cost", "kkt", "time_optimum", "final_times"))
    valves = [phase["quantised"] for phase in phases]
    together["quantised"] = None if None in valves else _valves_together(valves)
    count = together["active_intervals"]
    reached = all(phase["status"] == "reached" for phase in phases)
    together["status"] = "reached" if reached else "not reached"
    together["relative_sparsity_percent"] = 100.0 * count / (intervals * len(phases))
    together["obstacle"] = "; ".join(
        f"leg {number + 1}: {phase['obstacle']}"
        for number, phase in enumerate(phases)
        if phase["obstacle"]
    )
    return {name: together[name] for name in phases[0]}
