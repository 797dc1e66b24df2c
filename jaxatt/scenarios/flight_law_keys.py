"""Keys of the feedback laws in a flight's file."""

from __future__ import annotations

from collections.abc import Mapping

from jaxatt.problems.reading.keys import Choice, Flag, Keys, Number, Numbers, TableKey, Text

_PROPORTIONAL, _DERIVATIVE = "gain of the attitude", "gain of the rate"
_PD: Keys = {
    "proportional_1_s2": Number(_PROPORTIONAL, at_least=0.0, required=True),
    "derivative_1_s": Number(_DERIVATIVE, at_least=0.0, required=True),
}
_TWO: Keys = {
    "proportional_1_s2": Numbers("low and high gain of the attitude", size=2, required=True),
    "derivative_1_s": Numbers("low and high gain of the rate", size=2, required=True),
}
_SURFACE: Keys = {
    "surface": Choice("sliding surface", options=("pointing", "slewing"), default="pointing"),
    "slope_1_s": Number("slope of the surface", at_least=0.0, required=True),
}
_COUPLING: Keys = {
    "coupling_1_s": Number("coupling in the Lyapunov function", at_least=0.0, required=True),
    "inverse_inertia": Flag("whether the inverse inertia is taken, as printed"),
}

LAW_KEYS: Mapping[str, Keys] = {
    "pd": _PD,
    "tracking": _PD,
    "sliding-mode": {
        **_SURFACE,
        "gain_1_s2": Number("gain of the sign", above=0.0, required=True),
    },
    "super-twisting": {
        **_SURFACE,
        "first_gain": Number("first gain", above=0.0, required=True),
        "second_gain": Number("second gain", above=0.0, required=True),
        "beta": Number("factor of the linear terms", above=0.0, required=True),
    },
    "min-norm": {**_PD, **_COUPLING},
    "gain-scheduled": {
        **_TWO,
        **_COUPLING,
        "threshold_Nm": Number("torque between low and high gains", above=0.0, required=True),
    },
    "latched": {**_TWO, **_COUPLING},
    "krstic-tsiotras": {
        "first_gain_1_s": Number("first gain", above=0.0, required=True),
        "second_gain_1_s": Number("second gain", above=0.0, required=True),
        "factor": Number("factor of the cost", default=1.5, above=0.0),
    },
}
"""Keys of each kind of law; gains are in units of the inertia."""

LAW_HEADING: Keys = {
    "kind": Choice("kind of law", options=tuple(LAW_KEYS), required=True, example='"pd"'),
    "title": Text("name in figures", otherwise="that of the table"),
}

LAW = TableKey(
    "feedback law",
    LAW_HEADING,
    variants=LAW_KEYS,
)
