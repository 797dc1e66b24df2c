"""TOML tables of a scenario of net power, with the keys that each may hold."""

from __future__ import annotations

from dataclasses import replace

from jaxatt.problems.net_power.plan.reading.schema import (
    HORIZON_KEYS,
    PLAN_KEYS,
    TASK_KEYS,
)
from jaxatt.problems.reading.keys import Choice, Flag, Keys, Number, Numbers, TableKey
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES, Tables
from jaxatt.problems.reading.tables import manoeuvre
from jaxatt.problems.reading.tables.attitude import FRAME
from jaxatt.problems.reading.tables.orbit import LIGHT

KIND = "net-power"
"""Value of `objective.kind`."""
WHEEL_POWERS = ("signed", "body", "wheels")
COSTS = ("energy", "mean-power")
MAGNETORQUING = ("none", "manage-momentum", "decided")
"""Values of `magnetorquing.mode`: switched off, by the law (5.14), or by the optimiser."""

RESIDUAL_DIPOLE = Numbers("residual magnetic dipole, in body axes", size=3, default=[0.0, 0.0, 0.0])
EDDY = Number("coefficient of the torque of eddy currents", default=0.0, at_least=0.0)


def _and(table: TableKey, more: Keys) -> TableKey:
    return replace(table, keys_={**table, **more})


_HORIZON = _and(
    manoeuvre.HORIZON,
    {
        "horizon_s": replace(manoeuvre.HORIZON["horizon_s"], example="40.0"),
        "intervals": replace(manoeuvre.HORIZON["intervals"], required=False),
        "step_s": HORIZON_KEYS["step_s"],
    },
)

NET_POWER_TABLES: Tables = {
    "vehicle": SPACECRAFT_TABLES["vehicle"],
    "orbit": SPACECRAFT_TABLES["orbit"],
    "light": LIGHT,
    "initial": _and(manoeuvre.INITIAL, FRAME),
    "target": _and(
        manoeuvre.TARGET,
        {
            **FRAME,
            "wheel_speed_rad_s": Numbers(
                "speed of each wheel that is mounted, at the end", otherwise="free"
            ),
        },
    ),
    "plan": PLAN_KEYS,
    "tasks": TASK_KEYS,
    "horizon": replace(_HORIZON, required=False),
    "disturbances": TableKey(
        "torques that are not the actuators'",
        {
            "gravity_gradient": Flag("whether the gradient of gravity acts"),
            "residual_dipole_Am2": RESIDUAL_DIPOLE,
            "eddy_coefficient": EDDY,
        },
    ),
    "magnetorquing": TableKey(
        "use of the magnetorquers beside wheels",
        {
            "mode": Choice(
                "not at all, by a law that unloads the wheels, or decided with the torques",
                options=MAGNETORQUING,
                otherwise='"none"; "decided" without wheels',
            ),
            "gain": Number("gain of the law", above=0.0, example="5.0"),
            "wheel_speed_rad_s": Numbers(
                "speeds of the wheels that the law leads to", otherwise="standstill"
            ),
        },
    ),
    "objective": TableKey(
        "what is earned",
        {
            "kind": Choice("net energy", options=(KIND,), required=True, example='"net-power"'),
            **manoeuvre.TERMINAL,
            "cost": Choice("energy, or energy over time", options=COSTS, default="energy"),
            "wheel_power": Choice(
                "power of the wheels: signed, one magnitude over body axes, or each wheel by "
                "itself",
                options=WHEEL_POWERS,
                default="wheels",
            ),
            "attitude_weight_J": Number(
                'weight of the attitude in terminal = "penalty"', at_least=0.0, example="3.75e4"
            ),
            "rate_weight_J_s2": Number("weight of the rate there", at_least=0.0, example="3.75e4"),
            "attitude_weight_W": Number(
                "weight of the attitude of mean power", at_least=0.0, example="3.75e4"
            ),
            "rate_weight_W_s2": Number(
                "weight of the rate of mean power", at_least=0.0, example="3.75e4"
            ),
            "time_weight_W_s": Number(
                "price of a final time that is free", default=0.0, at_least=0.0
            ),
        },
        required=True,
    ),
    "baseline": TableKey(
        "PD law that answers are compared with",
        {
            "attitude_gain_Nm": Number(
                "gain of the attitude", above=0.0, required=True, example="8e-2"
            ),
            "rate_gain_Nm_s": Number(
                "gain of the rate, N m s", above=0.0, required=True, example="0.108"
            ),
            "turn_back_s": Number(
                "time before the end at which it turns to the target", default=20.0, at_least=0.0
            ),
            "hold_s": Number(
                "time for which a torque is held", above=0.0, otherwise="that of an interval"
            ),
            "nearest_to": Choice(
                "which sun attitude it takes: the nearest to the start or to the end",
                options=("start", "end"),
                default="start",
            ),
        },
    ),
    "limits": TableKey(
        "limits along the way",
        {
            "least_charge_percent": Number(
                "least charge of the battery", at_least=0.0, at_most=100.0, otherwise="no limit"
            )
        },
    ),
    "solver": SPACECRAFT_TABLES["solver"],
    "printed": manoeuvre.PRINTED,
}
"""[light] and [vehicle] are read by `problems.reading`, the rest by this family."""
