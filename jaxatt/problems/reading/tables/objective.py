"""Keys of [objective] where a spacecraft's torque or time is minimised."""

from __future__ import annotations

from jaxatt.problems.reading.keys import Choice, Number, TableKey, Whole
from jaxatt.problems.reading.tables.manoeuvre import TERMINAL

SPARSE_KINDS = ("l0", "moving-l0", "l1")
TIME_KINDS = ("time-effort", "minimum-time")
"""Values of `objective.kind`; the first is the default of its family."""

TIME_WEIGHT = Number(
    "price of the final time where it is free, for each second", default=0.0, at_least=0.0
)

OBJECTIVE = TableKey(
    "what is minimised",
    {
        "kind": Choice(
            "active intervals, active intervals weighted by windows, torque, time plus effort, or "
            "time",
            options=(*SPARSE_KINDS, *TIME_KINDS),
            default=SPARSE_KINDS[0],
        ),
        **TERMINAL,
        "design": Whole(
            "complementarity vectors: 1, one for all axes; 2 and 3, one an axis", default=1
        ),
        "epsilon_Nm": Number(
            "relaxation of the complementarity",
            above=0.0,
            otherwise="1e-8 of wheels of 3e-3 N m, in proportion of others",
        ),
        "rate_weight_s2": Number(
            'weight of the rate at the end in terminal = "penalty"', default=1e6, at_least=0.0
        ),
        "attitude_weight": Number(
            "weight of the attitude at the end there", default=1e2, at_least=0.0
        ),
        "sparsity_weight": Number(
            "weight of active intervals, or of torque, there",
            at_least=0.0,
            otherwise='10; for "l1" in inverse proportion to the torque limit',
        ),
        "waypoint_weight": Number("weight of the waypoint there", default=1e2, at_least=0.0),
        "on_off_weight": Number(
            "weight of switching thrusters on and off there", default=0.0, at_least=0.0
        ),
        "on_off_form": Choice(
            "whether that counts in active intervals, or as printed in idle ones, too",
            options=("active", "printed"),
            default="active",
        ),
        "time_weight_1_s": TIME_WEIGHT,
        "effort_weight": Number(
            'weight of the effort in "time-effort", 1/(N m)^2',
            at_least=0.0,
            otherwise="0.01 of torques of 0.55 N m, in proportion of others",
        ),
    },
)
