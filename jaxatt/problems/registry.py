"""Registry of the families of problems, one line a family.

What the files of a family hold is known at once; its code is loaded when a scenario asks for it.
"""

from __future__ import annotations

import pkgutil
from typing import TYPE_CHECKING

from jaxatt.problems.hands_off.file_format import FORMAT as HANDS_OFF
from jaxatt.problems.net_power.file_format import FORMAT as NET_POWER
from jaxatt.problems.reading.file_format import FileFormat, Formatted
from jaxatt.problems.time_optimal.file_format import FORMAT as TIME_OPTIMAL
from jaxatt.problems.toy.file_format import FORMAT as TOY

if TYPE_CHECKING:
    from jaxatt.problems.family import Family
    from jaxatt.problems.scenario import Scenario

_CODE = {
    HANDS_OFF: "jaxatt.problems.hands_off.family:HandsOff",
    TIME_OPTIMAL: "jaxatt.problems.time_optimal.family:TimeOptimal",
    NET_POWER: "jaxatt.problems.net_power.family:NetPower",
    TOY: "jaxatt.problems.toy.family:Toy",
}
FORMATS = tuple(_CODE)
"""What the files of the package's own families hold."""

_FORMATS: dict[str, Formatted] = {known.name: known for known in FORMATS}
_FAMILIES: dict[str, Family] = {}


def register(family: Family) -> None:
    """Make a family known to scenarios, `solve`, the command line and reports.

    Raises `ValueError` where its name, or a kind of one of its systems, is taken.
    """
    if family.name in _FORMATS:
        raise ValueError(f"family {family.name!r}: the name is taken; choose another")
    for known in formats():
        taken = set(known.kinds) & set(family.kinds)
        for system in set(known.systems) & set(family.systems) if taken else ():
            raise ValueError(
                f"family {family.name!r}: objective.kind = {sorted(taken)[0]!r} of system = "
                f"{system!r} is taken; choose another"
            )
    _FORMATS[family.name] = _FAMILIES[family.name] = family


def unregister(name: str) -> None:
    """Remove a registered family."""
    del _FORMATS[name]
    _FAMILIES.pop(name, None)


def formats() -> tuple[Formatted, ...]:
    """What the files of all registered families hold, those of the package first."""
    return tuple(_FORMATS.values())


def kinds() -> tuple[str, ...]:
    """Values of `objective.kind` that scenarios may have."""
    return tuple(dict.fromkeys(kind for known in formats() for kind in known.kinds))


def family_named(name: str) -> Family:
    """The family of a record; raises `KeyError` where it is not registered."""
    if name not in _FAMILIES:
        known = _FORMATS[name]
        assert isinstance(known, FileFormat)  # those from outside are families already
        _FAMILIES[name] = pkgutil.resolve_name(_CODE[known])()
    return _FAMILIES[name]


def family_of(scenario: Scenario) -> Family:
    """The family that a scenario belongs to."""
    return family_named(scenario.family)
