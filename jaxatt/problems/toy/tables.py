"""TOML tables of a scenario of a toy system."""

from __future__ import annotations

from jaxatt.problems.reading.keys import Choice, Number, Numbers, TableKey
from jaxatt.problems.reading.schema import Tables
from jaxatt.problems.reading.tables import manoeuvre
from jaxatt.problems.reading.tables.objective import SPARSE_KINDS, TIME_WEIGHT

STATES = 2

TOY_TABLES: Tables = {
    "initial": TableKey(
        "state at the start", {"state": Numbers("state", size=STATES, required=True)}, required=True
    ),
    "target": TableKey(
        "state at the end",
        {
            "state": Numbers("state", size=STATES, required=True),
            "tolerance": Number("largest error of it", default=1e-6, above=0.0),
        },
    ),
    "horizon": manoeuvre.HORIZON,
    "control": TableKey(
        "what is decided", {"limit": Number("largest control", default=1.0, above=0.0)}
    ),
    "objective": TableKey(
        "what is minimised",
        {
            "kind": Choice(
                "active intervals, those weighted by windows, or control",
                options=SPARSE_KINDS,
                default=SPARSE_KINDS[0],
            ),
            **manoeuvre.TERMINAL,
            "epsilon": Number("relaxation of the complementarity", default=1e-6, above=0.0),
            "time_weight_1_s": TIME_WEIGHT,
        },
    ),
    "windows": manoeuvre.WINDOWS,
    "solver": manoeuvre.SOLVER,
    "printed": manoeuvre.PRINTED,
}
