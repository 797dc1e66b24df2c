"""Numbers of a scenario's document by their names, such as `vehicle.wheels.torque_limit_Nm`."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from jaxatt.problems.reading.fields import ScenarioError, shown
from jaxatt.problems.reading.schema import nearest
from jaxatt.problems.reading.tables.vehicle import VEHICLE_PARTS
from jaxatt.problems.reading.vehicles import whole_vehicle
from jaxatt.problems.registry import family_of
from jaxatt.problems.scenario import Scenario

EVERY = "*"

Place = tuple[str | int, ...]
"""Keys and indices that lead to a value of a document."""


def whole_document(scenario: Scenario) -> dict[str, Any]:
    """Return the document of a scenario with the vehicle that it names written out."""
    document = copy.deepcopy(dict(scenario.document))
    if "vehicle" in document:
        document["vehicle"] = whole_vehicle(document["vehicle"], scenario.origin, scenario.folder)
    return document


def places(scenario: Scenario, document: Mapping[str, Any], name: str) -> tuple[Place, ...]:
    """Places of the numbers that a name stands for; `*` stands for all entries of a list.

    A key that the scenario may have, and leaves out, is a place as well.
    Raises `ScenarioError` where there is no such number; a near name is suggested.
    """
    parts = name.split(".")
    found = tuple(_following(document, parts, ()))
    if not found and _may_have(scenario, parts):
        return (tuple(parts),)
    if not found:
        raise ScenarioError(f"{name}: {scenario.name} has no such number; {_hint(document, name)}")
    for place in found:
        _check_number(name, value_at(document, place))
    return found


def value_at(document: Any, place: Place) -> Any:
    """Value at a place; None where a key is left out."""
    value = document
    for part in place:
        if isinstance(value, dict):
            value = value.get(part)
        else:
            value = None if value is None else value[part]
    return value


def set_at(document: dict[str, Any], place: Place, value: float | int) -> None:
    """Set the number at a place of a document."""
    *parents, last = place
    inner: Any = document
    for part in parents:
        inner = inner.setdefault(part, {}) if isinstance(inner, dict) else inner[part]
    inner[last] = value


def _following(value: Any, parts: Sequence[str], before: Place) -> Iterator[Place]:
    if not parts:
        yield before
        return
    part, rest = parts[0], parts[1:]
    if isinstance(value, dict) and part in value:
        yield from _following(value[part], rest, (*before, part))
    elif isinstance(value, list) and (part == EVERY or part.isdecimal()):
        for index in range(len(value)) if part == EVERY else (int(part),):
            if index < len(value):
                yield from _following(value[index], rest, (*before, index))
    elif part == EVERY and not rest and not isinstance(value, (dict, list)):
        yield before  # one number for all, as `torque_limit_Nm` of equal wheels


def _may_have(scenario: Scenario, parts: Sequence[str]) -> bool:
    if len(parts) == 3 and parts[0] == "vehicle" and scenario.vehicle is not None:
        return parts[2] in VEHICLE_PARTS.get(parts[1], ())
    tables = family_of(scenario).tables
    return len(parts) == 2 and parts[1] in tables.get(parts[0], ()) and parts[1] != "use"


def _check_number(name: str, value: Any) -> None:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return
    if isinstance(value, list):
        raise ScenarioError(
            f"{name}: is a list of {len(value)}; write {name}.0 for its first entry or {name}.* "
            "for all"
        )
    if isinstance(value, dict):
        raise ScenarioError(
            f"{name}: is a table; write one of its numbers, such as "
            f"{next((n for n in _names(value, name)), name)}"
        )
    raise ScenarioError(
        f"{name} = {shown(value)}: is no number, and a sweep varies numbers; write a study for "
        "each of its values, with the value under [fixed]"
    )


def _hint(document: Mapping[str, Any], name: str) -> str:
    known = list(_names(document, ""))
    ending = [each for each in known if each.endswith(f".{name}")]
    near = ending[0] if ending else nearest(name, known)
    if near is not None:
        return f"did you mean '{near}'?"
    return "its numbers begin with " + ", ".join(dict.fromkeys(k.split(".")[0] for k in known))


def _names(value: Any, before: str) -> Iterator[str]:
    """Names of all numbers within a value."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _names(item, f"{before}.{key}" if before else str(key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _names(item, f"{before}.{index}")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield before
