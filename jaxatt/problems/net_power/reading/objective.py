"""Read the objective of a scenario of net power."""

from __future__ import annotations

from typing import Any, NamedTuple

from jaxatt.problems.net_power.reading.tables import KIND, NET_POWER_TABLES
from jaxatt.problems.net_power.weights import Weights
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.scenario_parts import Objective
from jaxatt.spacecraft.parts.vehicle import Spacecraft


class EnergyObjective(NamedTuple):
    """What every objective has, the form of the wheels' power, the cost and its weights."""

    objective: Objective
    wheel_power: str
    cost: str
    weights: Weights


def read_objective(data: Any, origin: str, craft: Spacecraft, free_time: bool) -> EnergyObjective:
    """Read [objective]."""
    table = Table(data, origin, "[objective]", NET_POWER_TABLES["objective"])
    table.choice("kind")
    terminal = table.choice("terminal")
    cost = table.choice("cost")
    if cost == "mean-power" and not free_time:
        table.fail("cost", "in fixed time it is the same as energy", 'use "energy" or leave it out')
    if "wheel_power" in table and not craft.wheels.count:
        table.fail("wheel_power", "the vehicle has no wheels", "drop it")
    if "time_weight_W_s" in table and not free_time:
        table.fail(
            "time_weight_W_s", "the final time is fixed", 'drop it, or set final_time = "free"'
        )
    unit, other = ("W", "J") if cost == "mean-power" else ("J", "W")
    for key in (f"attitude_weight_{other}", f"rate_weight_{other}_s2"):
        if key in table:
            table.fail(
                key, f'cost = "{cost}" is in {unit}', f"give {key.replace(f'_{other}', f'_{unit}')}"
            )
    asked = (f"attitude_weight_{unit}", f"rate_weight_{unit}_s2")
    for key in asked:
        if key in table and terminal == "reach":
            table.fail(key, 'terminal = "reach" has no weights', 'drop it, or use "penalty"')
    attitude, rate = (table.number(key) if terminal == "penalty" else 0.0 for key in asked)
    weights = Weights(attitude, rate, table.number("time_weight_W_s"))
    wheel_power = table.choice("wheel_power")
    return EnergyObjective(Objective(kind=KIND, terminal=terminal), wheel_power, cost, weights)
