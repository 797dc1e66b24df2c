"""What the files of one family of problems hold."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from jaxatt.problems.reading.checking import find_faults
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.keys import Choice, Key, TableKey
from jaxatt.problems.reading.schema import (
    SPACECRAFT,
    SPACECRAFT_TABLES,
    SYSTEM,
    scenario_keys,
)


@dataclass(frozen=True, eq=False)
class FileFormat:
    """Values of `system` and of `objective.kind` that a family answers to, and its TOML tables.

    The first kind is the default.  title : of such files, as pages show it.
    parts : reads what takes no computing; its arguments are those of `Family.read`, and remarks
    before the faults.
    """

    name: str
    title: str
    systems: tuple[str, ...]
    kinds: tuple[str, ...]
    tables: Mapping[str, TableKey]
    parts: Callable[[dict[str, Any], str, Path | None, list[str], Faults], object]


class Formatted(Protocol):
    """Anything that says what files it reads: a family, or its `FileFormat`."""

    @property
    def name(self) -> str: ...

    @property
    def systems(self) -> tuple[str, ...]: ...

    @property
    def kinds(self) -> tuple[str, ...]: ...

    @property
    def tables(self) -> Mapping[str, TableKey]: ...


F = TypeVar("F", bound=Formatted)


def format_of(document: Mapping[str, Any], origin: str, formats: Sequence[F]) -> F:
    """The one of several formats that answers to a document's system and kind of objective.

    Raises `ScenarioError`.
    """
    systems = tuple(dict.fromkeys(system for each in formats for system in each.systems))
    top = {"system": replace(SYSTEM, options=systems)}
    table = Table(document, origin, "", TableKey(keys_=top, free=Key()))
    system = table.choice("system")
    fitting = [each for each in formats if system in each.systems]
    objective = document.get("objective", {})
    if not isinstance(objective, dict) or "kind" not in objective:
        return fitting[0]
    kinds = tuple(kind for each in fitting for kind in each.kinds)
    keys = TableKey(keys_={"kind": Choice(options=kinds)}, free=Key())
    kind = Table(objective, origin, "[objective]", keys).choice("kind")
    return next(each for each in fitting if kind in each.kinds)


def scenario_faults(
    document: Mapping[str, Any], origin: str, formats: Sequence[Formatted]
) -> list[ScenarioError]:
    """All faults of a scenario's document that can be told without computing."""
    plain = dict(document)
    try:
        found = format_of(plain, origin, formats)
    except ScenarioError as fault:
        place = plain if not fault.label else {**plain[fault.label.strip("[]")]}
        place.pop(fault.key)
        if fault.label:
            plain[fault.label.strip("[]")] = place
        return [fault, *scenario_faults(plain, origin, formats)]
    system, objective = plain.get("system", SPACECRAFT), plain.get("objective", {})
    told = f"system = {system}"
    if system == SPACECRAFT and isinstance(objective, dict) and "kind" in objective:
        told = f"kind = {objective['kind']}"
    elsewhere = [
        ScenarioError(
            f"{origin}: {key}: has no meaning for {told}; drop it",
            origin,
            "",
            key,
        )
        for key in plain
        if key in SPACECRAFT_TABLES and key not in found.tables
    ]
    rest = {key: value for key, value in plain.items() if key not in {f.key for f in elsewhere}}
    return [*elsewhere, *find_faults(rest, origin, scenario_keys(found.tables, found.systems))]
