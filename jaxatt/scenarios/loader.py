"""Load a checked scenario from a TOML document."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxatt.problems import registry
from jaxatt.problems.reading.attitudes import replaced_by
from jaxatt.problems.reading.documents import read_file
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.file_format import Formatted, format_of, scenario_faults
from jaxatt.problems.reading.wheel_axes import other_mounting
from jaxatt.problems.scenario import Scenario


def load_file(path: str | Path) -> Scenario:
    """Load and check the scenario of a TOML file.

    Raises
    ------
    ScenarioError
        Names file, table, key, value, what is allowed and how to mend it.
    """
    path = Path(path)
    return from_mapping(read_file(path), origin=str(path), folder=path.parent)


def from_mapping(
    document: Mapping[str, Any], *, origin: str = "scenario", folder: Path | None = None
) -> Scenario:
    """Check a document that has the names and units of a scenario file.

    Parameters
    ----------
    document : mapping
        As a TOML file holds it; NumPy numbers and arrays may stand for numbers and lists.
    origin : str
        What messages call it.
    folder : Path, optional
        Where a vehicle's file is looked up; the working folder by default.
    """
    plain = plain_values(document)
    faults = Faults(scenario_faults(plain, origin, registry.formats()))
    known = faults.of(format_of, plain, origin, registry.formats())
    scenario = faults.of(_read, known, plain, origin, folder, faults)
    faults.refuse()
    return scenario


def _read(
    known: Formatted, plain: dict[str, Any], origin: str, folder: Path | None, faults: Faults
) -> Scenario:
    return registry.family_named(known.name).read(plain, origin, folder, faults)


def replace(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    """Return a changed scenario, checked like a file.

    Parameters
    ----------
    scenario : Scenario
    changes : mapping
        New values by their names in the file, with its units, e.g.
        ``{"target.attitude_deg": [10, 20, 30], "objective.kind": "l1", "legs.0.rate_rad_s": ...}``.
        None removes a key. A new attitude replaces the old one in whichever form it was given.
    """
    document = copy.deepcopy(dict(scenario.document))
    for path, value in changes.items():
        assign(document, path, plain_values(value))
    return from_mapping(document, origin=scenario.origin, folder=scenario.folder)


def assign(document: dict[str, Any], path: str, value: Any) -> None:
    *parents, key = path.split(".")
    place: Any = document
    for part in parents:
        if isinstance(place, list) and part.isdigit() and int(part) < len(place):
            place = place[int(part)]
        elif isinstance(place, dict):
            place = place.setdefault(part, {})
        else:
            raise ScenarioError(f"{path}: there is no '{part}' to change; check the name")
    if isinstance(place, list) and key.isdigit() and int(key) < len(place):
        place[int(key)] = value
        return
    if not isinstance(place, dict):
        raise ScenarioError(f"{path}: there is no '{key}' to change; check the name")
    place.pop(key, None)
    if value is None:
        return
    for other in (*replaced_by(key), *other_mounting(key)):
        place.pop(other, None)
    place[key] = value


def plain_values(value: Any) -> Any:
    """Convert mappings, tuples and arrays to dicts, lists and Python numbers."""
    if isinstance(value, Mapping):
        return {str(key): plain_values(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_values(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value
