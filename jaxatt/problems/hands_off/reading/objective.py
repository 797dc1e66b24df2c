"""Read the sparse objectives of a scenario, and check a free final time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES
from jaxatt.problems.reading.tables.objective import SPARSE_KINDS
from jaxatt.problems.scenario_parts import Horizon, Objective

_TORQUE_LIMIT, _EPSILON, _SPARSITY_WEIGHT = 3e-3, 1e-8, 1e1
"""Of the wheels [N m], relaxation [N m] and k3 of Schaanning (2021), section 5.1 and table 5.1."""

_COMPARED = {
    "active_intervals": 1,
    "active_outside_windows": 1,
    "relative_sparsity_percent": 1,
    "cpu_time_nlp_s": 1,
}
PRINTED = {kind: _COMPARED for kind in SPARSE_KINDS}
"""What `jaxatt compare` sets beside its own values, for each kind."""


def read_objective(data: Any, origin: str, torque: float) -> Objective:
    """Read the objective; the defaults are those of Schaanning (2021), table 5.1.

    Those in units of torque are for its wheels, and in proportion for the vehicle's actuators.
    torque : [N m], the largest limit of these.
    """
    table = Table(data, origin, "[objective]", SPACECRAFT_TABLES["objective"])
    kind = table.choice("kind")
    if "effort_weight" in table:
        table.fail("effort_weight", f"not used by kind = {kind}", 'use kind = "time-effort"')
    design = table.integer("design")
    if design > 3:
        table.fail("design", "not one of the designs", "allowed: 1, 2, 3")
    stronger = torque / _TORQUE_LIMIT
    # What L1 weighs is a torque, what L0 weighs a number of intervals.
    sparsity = _SPARSITY_WEIGHT / (stronger if kind == "l1" else 1.0)
    return Objective(
        kind=kind,
        terminal=table.choice("terminal"),
        design=design,
        epsilon=table.number("epsilon_Nm", _EPSILON * stronger),
        rate_weight=table.number("rate_weight_s2"),
        attitude_weight=table.number("attitude_weight"),
        sparsity_weight=table.number("sparsity_weight", sparsity),
        waypoint_weight=table.number("waypoint_weight"),
        on_off_weight=table.number("on_off_weight"),
        on_off_form=table.choice("on_off_form"),
        time_weight=table.number("time_weight_1_s"),
    )


def check_free_time(
    document: Mapping[str, Any], origin: str, horizon: Horizon, objective: Objective
) -> None:
    """Refuse a free final time without a longest value, and a price on a fixed final time.

    Raises `ScenarioError`.
    """
    if horizon.free and not math.isfinite(horizon.longest):
        table = Table(document["horizon"], origin, "[horizon]", tuple(document["horizon"]))
        table.fail(
            "longest_s",
            "missing",
            f"a free final time of kind = {objective.kind} needs the longest allowed, in seconds",
        )
    if objective.time_weight > 0.0 and not horizon.free:
        table = Table(document["objective"], origin, "[objective]", tuple(document["objective"]))
        table.fail(
            "time_weight_1_s",
            "the final time is fixed, so its price changes nothing",
            'add [horizon] final_time = "free" and longest_s, or drop it',
        )
