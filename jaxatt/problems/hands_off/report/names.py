"""Entries that sparse control adds to a summary."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jaxatt.problems.answer import Answer
from jaxatt.problems.hands_off.record import Valves, sparse_section
from jaxatt.problems.hands_off.report.final_times import final_times_summary
from jaxatt.records.phase import Phase


def names(phase: Phase) -> dict[str, Any]:
    """Entries of one phase: weighted counts, final times that were tried, valves."""
    section = sparse_section(phase)
    return {
        "weighted_active_intervals": section.weighted(phase.active),
        "active_outside_windows": section.outside_windows(phase.active),
        "max_complementarity_Nm": section.max_complementarity,
        "final_times": final_times_summary(section.final_times),
        "quantised": valves_summary(section.quantised[0]) if section.quantised else None,
        "intervals_for_bias": None if section.bias is None else int(section.bias.added.sum()),
    }


def together(blocks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Entries of several phases: sums, worst values, and valves where every phase has them."""
    valves = [block["quantised"] for block in blocks]
    return {
        "weighted_active_intervals": sum(block["weighted_active_intervals"] for block in blocks),
        "active_outside_windows": sum(block["active_outside_windows"] for block in blocks),
        # max() would pass over a NaN, which is the worst of all.
        "max_complementarity_Nm": float(
            np.max([block["max_complementarity_Nm"] for block in blocks])
        ),
        "intervals_for_bias": _bias_together(blocks),
        "final_times": None,
        "quantised": None if None in valves else _valves_together(valves),
    }


def _bias_together(blocks: Sequence[Mapping[str, Any]]) -> int | None:
    counts = [block["intervals_for_bias"] for block in blocks]
    given = [count for count in counts if count is not None]
    return sum(given) if given else None


def whole(answer: Answer) -> dict[str, Any]:
    """Entries of the whole answer: the other kind of quantisation, of a single phase."""
    if len(answer.phases) > 1:
        return {"quantised_otherwise": None}
    others = sparse_section(answer.phases[0]).quantised[1:]
    return {"quantised_otherwise": valves_summary(others[0]) if others else None}


def valves_summary(valves: Valves) -> dict[str, Any]:
    """Plain numbers of an answer with thrusters open or shut; `on_time_s` by thruster."""
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
