"""Keys of the files of studies: sweeps and designs."""

from __future__ import annotations

from collections.abc import Mapping

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
    Texts,
    Whole,
)
from jaxatt.problems.reading.tables.attitude import POSE_KEYS
from jaxatt.problems.reading.tables.manoeuvre import HEADING, MOST_SEED

METHODS = ("grid", "random", "latin-hypercube", "sobol")
CHANGES = ("set", "multiply", "add")
WORST, MEAN = "worst", "mean"
MOST_SAMPLES = 10_000_000
"""Samples of one sweep."""
_MOST_POINTS, _MOST_TARGETS = 10_000, 10_000

_BASE: Keys = {"name": HEADING["name"], "title": HEADING["title"]}
_FIXED = TableKey(
    "what the scenario has otherwise: solver.starts = 8 and the like", free=Key("new value")
)
_SCENARIO = "bundled scenario, or a file beside this one"
LIMIT = Number("limit", above=0.0, required=True, example="40.0")
_SEED = Whole("seed of the random numbers", default=0, at_least=0, at_most=MOST_SEED)

_FIELD: Mapping[str, Key] = {
    "field": Either(
        "name of a number in the scenario, or a list of names that follow one value",
        forms=(Text(), Texts()),
        required=True,
        example='"vehicle.wheels.torque_limit_Nm"',
    ),
    "name": Text("name of the quantity", otherwise="the last part of the field"),
    "change": Choice("what a value does to the number", options=CHANGES, default="set"),
    "from": Number("least value", required=True, unless=("values",)),
    "to": Number("greatest value", required=True, unless=("values",), example="2.0"),
    "spacing": Choice(
        "how values lie between the two", options=("linear", "logarithmic"), default="linear"
    ),
}
_VARIED: Mapping[str, Key] = {
    **_FIELD,
    "values": Numbers("values, in place of from and to"),
    "count": Whole(
        "number of values between from and to, in a grid", at_least=2, at_most=MOST_SAMPLES
    ),
    "whole": Flag("whether only whole numbers are taken"),
}
VARY = TableKey(
    "quantities that are varied, one table each",
    _VARIED,
    many=True,
    required=True,
    apart=tuple(("values", key) for key in ("from", "to", "count", "spacing")),
)
DESIGN = TableKey("numbers that are chosen, one table each", _VARIED, many=True, required=True)

SAMPLING = TableKey(
    "samples of the quantities",
    {
        "method": Choice("how they are drawn", options=METHODS, default="grid"),
        "samples": Whole("how many, where it is no grid", at_most=MOST_SAMPLES),
        "seed": _SEED,
    },
)

STUDY_KEYS = TableKey(
    "sweep",
    {
        **_BASE,
        "scenario": Either(
            f"{_SCENARIO}; or a list of them", forms=(Text(), Texts()), required=True
        ),
        "outputs": Texts(
            "names of numbers in summary.json that are kept",
            required=True,
            example='["active_intervals", "l1_effort_Nms"]',
        ),
        "against": Texts("outputs that the others are drawn over, too", otherwise="none"),
        "chunk": Whole(
            "samples that are solved and written together",
            at_most=MOST_SAMPLES,
            otherwise="a 256th of all, at most 256",
        ),
        "fixed": _FIXED,
        "sampling": SAMPLING,
        "vary": VARY,
    },
)
"""Keys at the top of a sweep's file."""

DESIGN_KEYS = TableKey(
    "design",
    {
        **_BASE,
        "scenario": Text(_SCENARIO, required=True, example='"hypso1-90-45-15"'),
        "fixed": _FIXED,
        "minimise": Text(
            "name of a [[design]], or of the objective of an answer", otherwise="the objective"
        ),
        "at_most": TableKey(
            "limit of the objective, where a number is minimised",
            free=LIMIT,
        ),
        "over": Choice("of several targets, what counts", options=(WORST, MEAN), default=WORST),
        "targets": Either(
            "targets: a number that is spread evenly over all turns, or one table each",
            forms=(
                Whole(at_most=_MOST_TARGETS),
                TableKey("target", POSE_KEYS, many=True),
            ),
            otherwise="the scenario's",
        ),
        "points": Whole(
            "points at which the descent may begin",
            at_most=_MOST_POINTS,
            otherwise="4 for each number",
        ),
        "seed": _SEED,
        "design": DESIGN,
    },
)
"""Keys at the top of a design's file."""
