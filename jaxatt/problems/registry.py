"""Registry of the families of problems, one line a family."""

from __future__ import annotations

from jaxatt.problems.family import Family
from jaxatt.problems.hands_off.family import HandsOff
from jaxatt.problems.net_power.family import NetPower
from jaxatt.problems.scenario import Scenario
from jaxatt.problems.time_optimal.family import TimeOptimal
from jaxatt.problems.toy.family import Toy

_FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        HandsOff(),
        TimeOptimal(),
        NetPower(),
        Toy(),
    )
}


def register(family: Family) -> None:
    """Make a family known to scenarios, `solve`, the command line and reports.

    Raises `ValueError` where its name, or a kind of one of its systems, is taken.
    """
    if family.name in _FAMILIES:
        raise ValueError(f"family {family.name!r}: the name is taken; choose another")
    for system in family.systems:
        taken = set(kinds_of(system)) & set(family.kinds)
        if taken:
            raise ValueError(
                f"family {family.name!r}: objective.kind = {sorted(taken)[0]!r} of system = "
                f"{system!r} is taken; choose another"
            )
    _FAMILIES[family.name] = family


def unregister(name: str) -> None:
    """Remove a registered family."""
    del _FAMILIES[name]


def families() -> tuple[Family, ...]:
    """All registered families, those of the package first."""
    return tuple(_FAMILIES.values())


def family_named(name: str) -> Family:
    """The family of a record; raises `KeyError` where it is not registered."""
    return _FAMILIES[name]


def family_of(scenario: Scenario) -> Family:
    """The family that a scenario belongs to."""
    return _FAMILIES[scenario.family]


def systems() -> tuple[str, ...]:
    """Values of `system` that scenarios may have, in the order of registration."""
    return tuple(dict.fromkeys(system for family in families() for system in family.systems))


def families_of(system: str) -> tuple[Family, ...]:
    """Families that answer to a system."""
    return tuple(family for family in families() if system in family.systems)


def kinds_of(system: str) -> tuple[str, ...]:
    """Values of `objective.kind` that scenarios of a system may have."""
    return tuple(kind for family in families_of(system) for kind in family.kinds)
