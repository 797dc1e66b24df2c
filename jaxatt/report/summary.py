"""A result as plain numbers under stable names, as `summary.json` holds it.

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
from jaxatt.records.wording import LIMITS
from jaxatt.report.do_nothing import do_nothing_cost
from jaxatt.report.family import sections_of, sections_of_phase
from jaxatt.report.free_roll import free_roll
from jaxatt.runtime.json_files import plain, write_json

_ERRORS = {
    "attitude_error_deg": ("attitude", math.degrees(1.0)),
    "rate_error_rad_s": ("rate", 1.0),
    "waypoint_error_deg": ("waypoint", math.degrees(1.0)),
    "state_error": ("state", 1.0),
}
"""Name in the summary -> (name in `Phase.errors`, factor to its unit)."""

NAMES = (
    "status",
    "objective",
    "active_intervals",
    "active_interval_indices",
    "weighted_active_intervals",
    "active_outside_windows",
    "relative_sparsity_percent",
    *_ERRORS,
    "flight_error_deg",
    "flight_error_rad_s",
    "flight_steps",
    "search_steps",
    "max_torque_violation_Nm",
    "max_complementarity_Nm",
    "l1_effort_Nms",
    "final_time_s",
    "step_s",
    "control_effort",
    "cost",
    "kkt",
    "time_optimum",
    "final_times",
    "quantised",
    "pointing",
    "wheel_bands",
    "free_roll",
    "obstacle",
    "starts",
)
"""Names that every phase has in a summary, in their order; null where no family gives a value."""

_SUMS = ("active_intervals", "l1_effort_Nms", "final_time_s", "control_effort")
_STEPS = ("flight_error_deg", "flight_error_rad_s", "flight_steps", "search_steps")
_WORST = (*_ERRORS, *_STEPS, "max_torque_violation_Nm")


def summary(result: Answer) -> dict[str, Any]:
    """Plain numbers, texts and lists of a result, ready for JSON (no NaN, no arrays)."""
    phases = [_phase(phase) for phase in result.phases]
    several = len(phases) > 1
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
            **(_together(result, phases) if several else phases[0]),
            "do_nothing_cost": do_nothing_cost(result),
            "alternative": None if alternative is None else _phase(alternative),
            "quantised_otherwise": None,
            **sections_of(result).whole(result),
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


def starts_summary(starts: StartsRecord) -> dict[str, int]:
    """Number of starts made, converged and reached, and number of different answers."""
    return {
        "requested": len(starts.status),
        "converged": int((starts.status == int(Status.CONVERGED)).sum()),
        "reached_target": int(starts.reached.sum()),
        "distinct_minima": starts.distinct_minima,
    }


def _phase(phase: Phase) -> dict[str, Any]:
    """One phase under `NAMES`; what a family or its errors have beyond them comes after."""
    general = {
        "status": "reached" if phase.reached else "not reached",
        "objective": {"total": phase.total_cost, **phase.objective},
        "active_intervals": phase.active_intervals,
        "active_interval_indices": np.flatnonzero(phase.active).tolist(),
        "relative_sparsity_percent": 100.0 * phase.active_intervals / len(phase.active),
        "max_torque_violation_Nm": phase.limit_violation,
        "l1_effort_Nms": phase.l1_effort,
        "final_time_s": phase.final_time,
        "step_s": phase.step,
        "control_effort": phase.quadratic_effort,
        "pointing": _pointing(phase),
        "wheel_bands": _wheel_bands(phase),
        "free_roll": free_roll(phase),
        "obstacle": phase.failure_reason,
        "starts": starts_summary(phase.starts),
        **named_errors(phase),
        **_steps(phase),
    }
    return _in_order({**sections_of_phase(phase).names(phase), **general})


def _steps(phase: Phase) -> dict[str, float | int | None]:
    """Runge-Kutta steps an interval of search and flight, and what the flight is uncertain by."""
    error = phase.flight_error
    return {
        "flight_error_deg": None if error is None else math.degrees(error.attitude),
        "flight_error_rad_s": None if error is None else error.rate,
        "flight_steps": None if error is None else error.steps,
        "search_steps": phase.search_steps or None,
    }


def named_errors(phase: Phase) -> dict[str, float]:
    """Errors of a phase at its end under the names of a summary, in the units that these say."""
    return {
        **{
            name: phase.errors[key] * factor
            for name, (key, factor) in _ERRORS.items()
            if key in phase.errors
        },
        **{f"{key}_error": phase.errors[key] for key in _own_errors(phase)},
    }


def _own_errors(phase: Phase) -> list[str]:
    """Errors of a family's own."""
    known = {key for key, _ in _ERRORS.values()}
    return [key for key in phase.errors if key not in known]


def _in_order(block: Mapping[str, Any]) -> dict[str, Any]:
    return {**dict.fromkeys(NAMES), **block}


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


def _wheel_bands(phase: Phase) -> list[dict[str, Any]]:
    """Every band of speeds that wheels avoid, with one number a wheel."""
    return [
        {
            "name": band.name,
            "allowed_s": band.allowed,
            "longest_stay_s": band.stays.tolist(),
            "clearance_rad_s": band.clearance.tolist(),
            "outcome": band.outcome,
            "satisfied": band.satisfied,
        }
        for band in phase.wheel_bands
    ]


def _together(result: Answer, blocks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """All phases as one block."""
    sections = sections_of(result)
    own = [sections.names(phase) for phase in result.phases]
    together: dict[str, Any] = dict(sections.together(own)) if own[0] else {}
    together |= {name: sum(block[name] for block in blocks) for name in _SUMS}
    for name in (*_WORST, *(f"{key}_error" for key in _own_errors(result.phases[0]))):
        values = [block[name] for block in blocks if block[name] is not None]
        # max() would pass over a NaN, which is the worst of all.
        together[name] = float(np.max(values)) if values else None
    for name in ("objective", "starts"):
        together[name] = {
            part: sum(block[name][part] for block in blocks) for part in blocks[0][name]
        }
    lengths = [len(phase.active) for phase in result.phases]
    together["active_interval_indices"] = [
        index + before
        for before, block in zip(np.cumsum([0, *lengths[:-1]]).tolist(), blocks, strict=True)
        for index in block["active_interval_indices"]
    ]
    together["pointing"] = [
        {"leg": number + 1, **entry}
        for number, block in enumerate(blocks)
        for entry in block["pointing"]
    ]
    together["wheel_bands"] = [
        {"leg": number + 1, **entry}
        for number, block in enumerate(blocks)
        for entry in block["wheel_bands"]
    ]
    steps = {block["step_s"] for block in blocks}
    together["step_s"] = steps.pop() if len(steps) == 1 else None
    together["status"] = result.status
    together["relative_sparsity_percent"] = 100.0 * together["active_intervals"] / sum(lengths)
    together["obstacle"] = "; ".join(
        f"leg {number + 1}: {block['obstacle']}"
        for number, block in enumerate(blocks)
        if block["obstacle"]
    )
    return _in_order(together)
