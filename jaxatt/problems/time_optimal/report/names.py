"""Entries that a turn in free time adds to a summary and to an archive's attributes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jaxatt.problems.answer import Answer
from jaxatt.problems.time_optimal.record import TimeOptimum, time_optimum
from jaxatt.records.phase import Phase

_OPTIMUM = ("cost", "kkt", "time_optimum")


def names(phase: Phase) -> dict[str, Any]:
    """Entries of one phase: cost, first-order conditions, switches, optimality.

    There are no windows: every active interval counts as one and lies outside them.
    """
    optimum = time_optimum(phase)
    return {
        "weighted_active_intervals": float(phase.active_intervals),
        "active_outside_windows": phase.active_intervals,
        "cost": optimum.cost,
        "kkt": optimum.kkt,
        "time_optimum": plain(optimum),
    }


def together(blocks: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Entries of several phases: sums of counts; optima stand with their phases only."""
    counts = ("weighted_active_intervals", "active_outside_windows")
    return {name: sum(block[name] for block in blocks) for name in counts} | dict.fromkeys(_OPTIMUM)


def plain(optimum: TimeOptimum) -> dict[str, Any]:
    """Plain numbers of an optimum, ready for JSON."""
    return {
        "effort_weight": optimum.effort_weight,
        "switch_times_s": switches(optimum),
        "largest_torque_share": optimum.torque_share,
        "resolved_final_time_s": optimum.resolved_time,
        "minima": optimum.minima,
        "share_at_best": optimum.share,
        "transcription": {
            "attitude": optimum.attitude,
            "integration": optimum.integration,
            "attitude_error_deg": float(np.degrees(optimum.own_error)),
        },
    }


def switches(optimum: TimeOptimum) -> dict[str, list[float]]:
    """Switch times [s] of each actuator, by its name."""
    named = zip(optimum.actuators, optimum.switch_times, strict=True)
    return {name: times.tolist() for name, times in named}


def attributes(answer: Answer) -> dict[str, str]:
    """Switch times of every phase, as JSON."""
    found = [switches(time_optimum(phase)) for phase in answer.phases]
    return {"switch_times_s": json.dumps(found)}
