"""Tables and keys that are allowed in a flight's file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from jaxatt.problems.reading.keys import (
    Choice,
    Flag,
    Number,
    Numbers,
    TableKey,
    Text,
    Whole,
)
from jaxatt.problems.reading.schema import SPACECRAFT_TABLES, Tables
from jaxatt.problems.reading.tables import manoeuvre
from jaxatt.problems.reading.tables.attitude import (
    FILE_KEYS,
    FORMS,
    POSE_KEYS,
    RATE_FORMS,
    RATE_KEYS,
)
from jaxatt.problems.reading.tables.orbit import EPOCH
from jaxatt.scenarios.flight_law_keys import LAW

MOST_RUNS = 10_000_000
MOST_STEPS = 10_000_000
"""Runge-Kutta steps of a flight whose surroundings fit into memory."""

_LEVER = Numbers("from the centre of mass to that of pressure, in body axes", size=3, required=True)

DRAG_KEYS = TableKey(
    "drag of the air",
    {
        "density_kg_m3": Number("density of the air", at_least=0.0, required=True),
        "area_m2": Number("area across the velocity", at_least=0.0, required=True),
        "coefficient": Number("coefficient of drag", at_least=0.0, required=True),
        "lever_m": _LEVER,
        "corotating": Flag("whether the air turns with the Earth"),
    },
)
SOLAR_KEYS = TableKey(
    "pressure of sunlight",
    {
        "irradiance_W_m2": Number("power of sunlight", default=1361.0, at_least=0.0),
        "light_speed_m_s": Number("speed of light", default=299792458.0, above=0.0),
        "area_m2": Number("area across the light", at_least=0.0, required=True),
        "reflectance": Number("share that is reflected", at_least=0.0, at_most=1.0, required=True),
        "lever_m": _LEVER,
    },
)

_ENVIRONMENT = TableKey(
    "torques that are not the actuators'; all but the sine need an [orbit]",
    {
        "epoch": replace(EPOCH, otherwise="none"),
        "gravity_gradient": Flag("whether the gradient of gravity acts"),
        "sinusoidal_torque_Nm": manoeuvre.DISTURBANCES["sinusoidal_torque_Nm"],
        "sinusoidal_frequency_rad_s": manoeuvre.DISTURBANCES["sinusoidal_frequency_rad_s"],
        "sun_direction": Numbers(
            "direction to a sun that rests, in inertial axes",
            size=3,
            otherwise="the sun of the date",
        ),
        "drag": DRAG_KEYS,
        "solar_pressure": SOLAR_KEYS,
        "residual_dipole_Am2": Numbers(
            "residual magnetic dipole, in body axes", size=3, otherwise="none"
        ),
        "eddy_coefficient": Number(
            "coefficient of the torque of eddy currents", at_least=0.0, otherwise="none"
        ),
    },
)

_REFERENCE = TableKey(
    "what the laws follow",
    {
        **POSE_KEYS,
        **RATE_KEYS,
        "from_s": Number("when it begins", default=0.0, at_least=0.0),
        "attitude_held": Flag(
            "whether the attitude moves on with the rate, rather than staying", default=True
        ),
        "manoeuvre": Text("scenario whose answer is followed", otherwise="none"),
        **FILE_KEYS,
    },
    apart=(*FORMS, RATE_FORMS),
)

_SIMULATION = TableKey(
    "length and steps of the flight",
    {
        "duration_s": Number("length", above=0.0, required=True, example="400.0"),
        "sampling_s": Number("period of the law", above=0.0, required=True, example="0.1"),
        "step_s": Number("Runge-Kutta step", above=0.0, otherwise="sampling_s"),
        "hold": Choice("torque between two samples", options=("zero-order",), default="zero-order"),
        "records": Whole("records that are kept", default=400),
        "tumbling_rad_s": Number("rate at which a run has failed", default=10.0, above=0.0),
    },
    required=True,
)

FLIGHT_TABLES: Tables = {
    "vehicle": SPACECRAFT_TABLES["vehicle"],
    "orbit": SPACECRAFT_TABLES["orbit"],
    "environment": _ENVIRONMENT,
    "initial": SPACECRAFT_TABLES["initial"],
    "reference": _REFERENCE,
    "simulation": _SIMULATION,
    "settling": TableKey(
        "when a run has settled",
        {
            "signal": Choice("what is watched", options=("attitude", "rate"), default="attitude"),
            "band_deg": Number("error of the attitude within which it has", default=0.5, above=0.0),
            "band_rad_s": Number("error of the rate", above=0.0, example="4e-4"),
            "since_s": Number(
                "instant from which it counts", at_least=0.0, otherwise="from_s of [reference]"
            ),
        },
    ),
    "noise": TableKey(
        "standard deviations of what is measured",
        {
            "rate_rad_s": Number("of the rate", default=0.0, at_least=0.0),
            "wheel_speed_rad_s": Number("of the wheel speeds", default=0.0, at_least=0.0),
        },
    ),
    "dumping": TableKey(
        "law by which magnetorquers unload the wheels",
        {
            "gain_1_s": Number("gain", above=0.0, required=True, example="1.5e-2"),
            "form": Choice(
                "with the 1/|B| that the printed law lacks, or as printed",
                options=("effective", "printed"),
                default="effective",
            ),
            **manoeuvre.WHEEL_SPEEDS,
        },
    ),
    "laws": TableKey(
        "feedback laws, one table [laws.NAME] each",
        free=LAW,
        required=True,
    ),
    "campaign": TableKey(
        "spread of many runs, one standard deviation each",
        {
            "runs": Whole("number of runs", default=1000, at_most=MOST_RUNS),
            "seed": Whole("seed of the runs", default=0, at_least=0),
            "attitude_deg": Number("of the initial attitude", default=0.0, at_least=0.0),
            "rate_rad_s": Number("of the initial rate", default=0.0, at_least=0.0),
            "inertia_percent": Number("of the inertia", default=0.0, at_least=0.0, at_most=50.0),
            "misalignment_deg": Number(
                "of the wheel axes", default=0.0, at_least=0.0, at_most=45.0
            ),
            "gain_percent": Number(
                "of the gains of the law", default=0.0, at_least=0.0, at_most=50.0
            ),
        },
    ),
    "printed": manoeuvre.PRINTED,
}

FLIGHT_KEYS = TableKey("flight", {**manoeuvre.HEADING, **FLIGHT_TABLES})
"""Keys at the top of a flight's file."""

PRINTED_FIGURES: Mapping[str, int] = {
    "settling_s": 3,
    "settling_worst_s": 1,
    "rms_deg": 3,
    "rms_rad_s": 3,
    "peak_Nm": 3,
    "settling_limit_s": 1,
    "integral_Nms": 1,
}
"""Figures of [printed.LAW] that are compared, and how many numbers each has."""
