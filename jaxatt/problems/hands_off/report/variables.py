"""Variables that sparse control adds to an archive."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from jaxatt.problems.hands_off.record import Valves, sparse_section
from jaxatt.problems.hands_off.report.final_times import final_times_variables
from jaxatt.records.labels import Variable, labelled
from jaxatt.records.phase import Phase


def variables(phase: Phase, phases: Sequence[Phase]) -> dict[str, Variable]:
    """Variables of windows by interval, valves as they flew, and final times that were tried."""
    section = sparse_section(phase)
    tried = (sparse_section(one).final_times for one in phases)
    most = max((len(times.how) for times in tried if times is not None), default=0)
    along = ("interval",)
    return {
        "weight": labelled(section.weight, along, "1", "cost of the interval if active"),
        "window": labelled(section.window, along, "", "whether in a cheap window"),
        "forbidden": labelled(section.forbidden, along, "", "whether torque is forbidden"),
        **(_valves(section.quantised[0]) if section.quantised else {}),
        **final_times_variables(phase, most),
    }


def _valves(valves: Valves) -> dict[str, Variable]:
    flown: dict[str, tuple[Any, tuple[str, ...], str, str]] = {
        "opens": (valves.opens, ("interval", "thruster"), "s", "opening after its start"),
        "shuts": (valves.shuts, ("interval", "thruster"), "s", "shutting after its start"),
        "q_ob": (valves.q_ob, ("time", "quaternion"), "1", "attitude with valves"),
        "omega_ob": (valves.omega_ob, ("time", "axis"), "rad/s", "rate with valves"),
        "attitude_error": (valves.errors["attitude"], (), "rad", "attitude error with valves"),
        "rate_error": (valves.errors["rate"], (), "rad/s", "rate error with valves"),
    }
    return {f"quantised_{name}": labelled(*rest) for name, rest in flown.items()}
