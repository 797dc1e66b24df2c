"""Names that net power adds to a summary, and its attributes of an archive."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from jaxatt.problems.answer import Answer
from jaxatt.problems.net_power.record import Energy, energy_of, mean_power, net_power
from jaxatt.problems.sections import Block
from jaxatt.records.phase import Phase


def energy_names(energy: Energy, seconds: float) -> dict[str, Any]:
    """Energies as a summary holds them: joules, watts and per cent."""
    base, gain = energy.baseline, energy.gain
    return {
        "net_J": energy.net,
        "solar_J": energy.solar,
        "actuation_J": energy.actuation,
        "loads_J": energy.loads,
        "mean_power_W": mean_power(energy, seconds),
        "baseline_J": base,
        # Of a baseline that earns: of one that loses, a percentage says nothing.
        "gain_percent": 100.0 * gain / base if gain is not None and base and base > 0.0 else None,
        "gain_J": gain,
        "final_charge_J": energy.final_charge,
        "least_charge_J": energy.least_charge,
    }


def names(phase: Phase) -> Block:
    """Names of one phase: its energy, what the solver claimed, its shadow and its optimality."""
    found = net_power(phase)
    return {
        "kkt": {"violation": found.violation, "stationarity": found.stationarity},
        "energy": energy_names(found.energy, phase.final_time),
        "net_power": {
            "claimed_J": found.claimed,
            "cost": found.cost,
            "share_at_best": found.share,
            "refined_starts": found.refined,
            "minima": found.minima,
            "shadow_s": [
                {name: None if math.isnan(time) else time for name, time in vars(passage).items()}
                for passage in found.shadow
            ],
            "task": found.task or None,
            "mode": found.mode or None,
            "dipole_saturated_percent": None
            if found.saturated is None
            else 100.0 * found.saturated,
        },
    }


def together(blocks: Sequence[Block]) -> Block:
    """The same of several phases; `whole` has their energy."""
    return {
        "kkt": {
            name: max(block["kkt"][name] for block in blocks)
            for name in ("violation", "stationarity")
        },
        "energy": None,
        "net_power": None,
    }


def whole(answer: Answer) -> Block:
    """Energy of all phases together, and a plan's list of tasks."""
    seconds = sum(phase.final_time for phase in answer.phases)
    return {
        "energy": energy_names(energy_of(answer.phases), seconds),
        "plan": [_task(phase) for phase in answer.phases if net_power(phase).task],
    }


def _task(phase: Phase) -> Mapping[str, Any]:
    found = net_power(phase)
    return {
        "name": found.task,
        "mode": found.mode,
        "start_s": phase.start_time,
        "duration_s": phase.final_time,
        "reached": phase.reached,
        "failure_reason": phase.failure_reason,
        "energy": energy_names(found.energy, phase.final_time),
    }


def attributes(answer: Answer) -> dict[str, str]:
    """Energies and shadow as JSON."""
    return {
        "energy": json.dumps(whole(answer)["energy"]),
        "shadow_s": json.dumps([names(phase)["net_power"]["shadow_s"] for phase in answer.phases]),
    }
