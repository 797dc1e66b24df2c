"""Keys of the tables that say how a manoeuvre begins, passes and ends, and how it is solved."""

from __future__ import annotations

from jaxatt.problems.reading.keys import (
    Choice,
    Either,
    Flag,
    Key,
    Keys,
    Number,
    Numbers,
    TableKey,
    Text,
    Whole,
)
from jaxatt.problems.reading.tables.attitude import (
    FILE_KEYS,
    FORMS,
    GIVEN,
    POSE_KEYS,
    RATE_FORMS,
    RATE_KEYS,
    TOWARD_KEYS,
    tolerances,
)

MOST_INTERVALS, MOST_SUBSTEPS, MOST_STEPS = 100_000, 10_000, 10_000_000
"""Control intervals of a horizon, and Runge-Kutta steps of an interval and of all of them."""
MOST_STARTS, MOST_SEED = 1_000_000, 2**31 - 1
"""Starts whose outcomes fit into memory, and the largest seed."""

WHEEL_SPEEDS: Keys = {
    "wheel_speed_rad_s": Numbers("speed of each wheel that is mounted", otherwise="all stand still")
}

INITIAL = TableKey(
    "attitude, rate and wheel speeds at the start",
    {**POSE_KEYS, **RATE_KEYS, **WHEEL_SPEEDS, **FILE_KEYS},
    apart=(*FORMS, RATE_FORMS),
    required=True,
)

TARGET = TableKey(
    "attitude and rate at the end",
    {
        **POSE_KEYS,
        **RATE_KEYS,
        **tolerances(0.01, 1e-5),
        "wheel_bias_rad_s": Either(
            "speeds of the wheels that store no momentum: along the null vector of four wheels, or "
            "one for each wheel",
            forms=(Number(), Numbers()),
            otherwise="not asked for",
        ),
        "wheel_bias_tolerance_rad_s": Number(
            "largest error of that, on every wheel", default=0.1, above=0.0
        ),
    },
    apart=(*FORMS, RATE_FORMS),
)

LEGS = TableKey(
    "successive targets, each at the end of one horizon, in place of [target]",
    TARGET.keys_,
    apart=TARGET.apart,
    many=True,
)

WAYPOINT = TableKey(
    "attitude on the way",
    {
        **POSE_KEYS,
        "time_s": Number("when it is passed", required=True, unless=("node",), example="35.0"),
        "node": Whole("the same as a number of intervals from the start"),
        "tolerance_deg": Number("largest error there", default=0.1, above=0.0, at_most=180.0),
    },
    apart=(*FORMS, ("node", "time_s")),
)

FINAL_TIME: Keys = {
    "final_time": Choice(
        "whether the final time is given or found",
        options=("fixed", "free"),
        otherwise='"fixed", or "free" where time is minimised',
    ),
    "shortest_s": Number("shortest final time that is free", default=0.0, at_least=0.0),
    "longest_s": Number("longest final time that is free", above=0.0, otherwise="no limit"),
}

HORIZON = TableKey(
    "time that a manoeuvre takes, and the intervals that it is cut into",
    {
        "horizon_s": Number(
            "length", above=0.0, otherwise="longest_s where the final time is free", example="70.0"
        ),
        "intervals": Whole(
            "control intervals", at_most=MOST_INTERVALS, required=True, example="50"
        ),
        "coast_intervals": Whole(
            "intervals that are flown without torque after the end",
            default=20,
            at_least=0,
            at_most=MOST_INTERVALS,
        ),
        "substeps": Whole(
            "Runge-Kutta steps of an interval", at_most=MOST_SUBSTEPS, otherwise="chosen"
        ),
        **FINAL_TIME,
    },
    required=True,
)

DISTURBANCES = TableKey(
    "torques that are not the actuators'",
    {
        "gravity_gradient": Flag("whether the gradient of gravity acts"),
        "sinusoidal_torque_Nm": Number("amplitude of a sine, about each body axis", default=0.0),
        "sinusoidal_frequency_rad_s": Number("frequency of that sine", default=1.0, at_least=0.0),
    },
)

CONTROL = TableKey(
    "what is decided in each interval",
    {
        "axes": Choice(
            "torques about the body axes, or those of each wheel or thruster",
            options=("body", "wheels"),
            otherwise='"body"; "wheels" with thrusters and in minimum time',
        ),
        "quantisation": Choice(
            "how thrusters are flown: open for a part of each interval, for all of it or not at "
            "all, or at any level",
            options=("pulse-width", "interval", "none"),
            otherwise='"pulse-width"; "none" in minimum time',
        ),
    },
)

TERMINAL: Keys = {
    "terminal": Choice(
        "whether the target is a constraint or a penalty in the cost",
        options=("reach", "penalty"),
        default="reach",
    )
}

TRANSCRIPTION = TableKey(
    "how a turn in minimum time is transcribed",
    {
        "attitude": Choice(
            "coordinates of the attitude", options=("quaternion", "mrp"), default="quaternion"
        ),
        "integration": Choice("steps of the integration", options=("rk4", "euler"), default="rk4"),
    },
)

WINDOWS = TableKey(
    "intervals in which torque is cheap or forbidden",
    {
        "first_interval": Whole(
            "first of them, counted from 0", at_least=0, required=True, unless=("start_s", "end_s")
        ),
        "last_interval": Whole(
            "last of them, included", at_least=0, required=True, unless=("start_s", "end_s")
        ),
        "start_s": Number("the same in seconds", example="28.0"),
        "end_s": Number("the same in seconds", example="42.0"),
        "weight": Number("weight of an active interval inside", default=0.001, at_least=0.0),
        "forbidden": Flag("whether torque is barred inside"),
    },
    many=True,
)


def _cones(meaning: str) -> TableKey:
    keys: dict[str, Key] = {
        "name": Text("name of the cone, for reports", required=True),
        "boresight": Numbers(
            "axis in the body, of any length", size=3, required=True, example="[0.0, 0.0, 1.0]"
        ),
        "half_angle_deg": Number(
            "half of the opening, less than 180", above=0.0, required=True, example="30.0"
        ),
        **TOWARD_KEYS,
    }
    return TableKey(meaning, keys, many=True, apart=(GIVEN,))


KEEP_OUT = _cones("body axes that stay out of a cone about a direction")
KEEP_IN = _cones("body axes that stay in a cone about a direction")

LIMITS = TableKey(
    "limits along the way",
    {
        "body_rate_deg_s": Either(
            "largest rate relative to the inertial frame, about every body axis or about each",
            forms=(Number(above=0.0), Numbers(size=3, above=0.0)),
            otherwise="no limit",
        )
    },
)

SOLVER = TableKey(
    "search",
    {
        "starts": Whole("number of starts", default=64, at_most=MOST_STARTS),
        "seed": Whole("seed of the random starts", default=0, at_least=0),
    },
)

PRINTED = TableKey(
    "what the source prints, to be compared; other keys are for the reader", free=Key()
)

HEADING: Keys = {
    "name": Text("name that results are written under", otherwise="that of the file"),
    "title": Text("one line about it", otherwise="the name"),
    "source": Text("where its numbers are from", otherwise='"not stated"'),
}
