"""Kinds of TOML files, and the faults of each that can be told without computing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jaxatt.problems.reading.checking import find_faults
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.file_format import FileFormat, format_of, scenario_faults
from jaxatt.problems.reading.keys import TableKey
from jaxatt.problems.reading.tables.vehicle import VEHICLE_FILE_KEYS
from jaxatt.problems.reading.vehicles import load_vehicle_file, read_vehicle
from jaxatt.problems.registry import formats
from jaxatt.scenarios.flight_schema import FLIGHT_KEYS
from jaxatt.studies.tables import DESIGN_KEYS, STUDY_KEYS

OTHERS: Mapping[str, TableKey] = {
    "flight": FLIGHT_KEYS,
    "study": STUDY_KEYS,
    "design": DESIGN_KEYS,
    "vehicle": VEHICLE_FILE_KEYS,
}
"""Keys at the top of all kinds of files but scenarios, which their families declare."""

_TOLD_BY = {
    "flight": ("simulation", "laws"),
    "study": ("vary", "outputs", "sampling"),
    "design": ("design", "minimise"),
    "vehicle": ("inertia_kgm2", "wheels"),
}
"""Keys that only one kind of file has."""


def kind_of_document(document: Mapping[str, Any]) -> str:
    """The kind of a file: one of `OTHERS`, or "manoeuvre"."""
    return next(
        (kind for kind, keys in _TOLD_BY.items() if any(key in document for key in keys)),
        "manoeuvre",
    )


def faults_of(
    document: dict[str, Any], origin: str, kind: str, folder: Path | None = None
) -> Sequence[ScenarioError]:
    """All faults of a document of a kind that can be told without computing.

    folder : where files that it names are; None where these are still to be written, and only keys
    are looked at.
    """
    if kind != "manoeuvre":
        faults = Faults(find_faults(document, origin, OTHERS[kind]))
        if folder is not None and kind == "flight":
            faults.of(read_vehicle, faults.table(document, "vehicle"), origin, folder, [])
        if folder is not None and kind == "vehicle":
            faults.of(load_vehicle_file, Path(origin))
        return faults.found
    faults = Faults(scenario_faults(document, origin, formats()))
    known = faults.of(format_of, document, origin, formats())
    if folder is not None and isinstance(known, FileFormat):  # no family from outside
        known.parts(document, origin, folder, [], faults)
    return faults.found
