"""The families of problems, by name."""

from __future__ import annotations

from dataclasses import dataclass

from jaxatt.problems.hands_off.report.sections import HANDS_OFF
from jaxatt.problems.sections import Sections
from jaxatt.problems.time_optimal.report.sections import TIME_OPTIMAL
from jaxatt.problems.toy.report import TOY


@dataclass(frozen=True)
class Family:
    """A family of problems."""

    name: str
    sections: Sections


_FAMILIES = {
    family.name: family
    for family in (
        Family("hands-off", HANDS_OFF),
        Family("time-optimal", TIME_OPTIMAL),
        Family("toy", TOY),
    )
}


def family_named(name: str) -> Family:
    """The family of a record."""
    return _FAMILIES[name]
