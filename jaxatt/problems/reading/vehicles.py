"""Read the vehicle of a scenario: bundled, in a file of its own, or written in place."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from jaxatt.problems.reading.documents import parse, read_file
from jaxatt.problems.reading.faults import Faults
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.schema import nearest
from jaxatt.problems.reading.tables.vehicle import VEHICLE, VEHICLE_FILE_KEYS, VEHICLE_PARTS
from jaxatt.problems.reading.vehicle_actuators import (
    read_magnetorquers,
    read_thrusters,
    read_wheels,
)
from jaxatt.problems.reading.vehicle_part import TOML_NAMES, checked, part
from jaxatt.problems.reading.vehicle_power import read_battery, read_loads, read_panels
from jaxatt.problems.reading.wheel_axes import other_mounting
from jaxatt.spacecraft.checks import FieldError
from jaxatt.spacecraft.inertia import checked_inertia
from jaxatt.spacecraft.parts.vehicle import Spacecraft, create


def _folder() -> Traversable:
    return resources.files("jaxatt.spacecraft") / "vehicles"


def vehicle_names() -> tuple[str, ...]:
    """Return the names of the bundled vehicles."""
    files = (entry.name for entry in _folder().iterdir())
    return tuple(sorted(name[:-5] for name in files if name.endswith(".toml")))


def load_vehicle(name: str) -> Spacecraft:
    """Return a bundled vehicle, e.g. ``load_vehicle("hypso1")``."""
    return read_vehicle({"use": name}, "load_vehicle", None, [], magnetorquers_alone=True)


def load_vehicle_file(path: Path) -> Spacecraft:
    """Return the vehicle of a file of its own."""
    return vehicle_from_mapping(
        whole_vehicle({"file": path.name}, str(path), path.parent), str(path)
    )


def vehicle_from_mapping(document: dict[str, Any], origin: str) -> Spacecraft:
    """Return the vehicle of a document whose parts stand at the top; origin : for messages."""
    return _build(Table(document, origin, "", VEHICLE_FILE_KEYS), [], magnetorquers_alone=True)


def read_vehicle(
    data: Any,
    origin: str,
    folder: Path | None,
    notes: list[str],
    *,
    magnetorquers_alone: bool = False,
) -> Spacecraft:
    """Read and check the vehicle of a [vehicle] table.

    Parameters
    ----------
    data : object
        The table: ``use`` or ``file`` with or without overrides, or all keys in place.
    origin : str
        The scenario's file, for messages.
    folder : Path or None
        Where ``file`` is looked up; None stands for the working folder.
    notes : list of str
        Receives remarks, e.g. an axis that was scaled to unit length.
    magnetorquers_alone : bool
        Whether a vehicle may have neither wheels nor thrusters.
    """
    merged = whole_vehicle(data, origin, folder)
    whole = Table(merged, origin, "[vehicle]", VEHICLE_FILE_KEYS)
    return _build(whole, notes, magnetorquers_alone)


def whole_vehicle(data: Any, origin: str, folder: Path | None) -> dict[str, Any]:
    """Return a [vehicle] table with all keys of the vehicle that it uses, its own on top.

    Arguments as for `read_vehicle`.
    """
    table = Table(data, origin, "[vehicle]", VEHICLE)
    for name, keys in VEHICLE_PARTS.items():
        if name in table:
            Table(table.data[name], origin, f"[vehicle.{name}]", keys)
    base: dict[str, Any] = {}
    if "use" in table:
        base = _bundled(table)
    elif "file" in table:
        base = _from_file(table, folder)
    elif "inertia_kgm2" not in table:
        table.fail(
            "inertia_kgm2",
            "missing",
            f'add it, or take a bundled vehicle with use = "{vehicle_names()[0]}"',
        )
    overrides = {key: value for key, value in table.data.items() if key not in ("use", "file")}
    merged = {**base, **overrides}
    for name in VEHICLE_PARTS:
        if name in base and name in overrides:
            replaced = {old for key in overrides[name] for old in other_mounting(key)}
            kept = {key: value for key, value in base[name].items() if key not in replaced}
            merged[name] = {**kept, **overrides[name]}
    return merged


def _bundled(table: Table) -> dict[str, Any]:
    name = table.text("use")
    names = vehicle_names()
    if name not in names:
        near = nearest(name, names)
        hint = f"did you mean '{near}'? " if near else ""
        table.fail("use", "no bundled vehicle", f"{hint}bundled: {', '.join(names)}")
    file_name = f"{name}.toml"
    text = (_folder() / file_name).read_text(encoding="utf-8")
    return parse(text, file_name)


def _from_file(table: Table, folder: Path | None) -> dict[str, Any]:
    path = (folder or Path()) / table.text("file")
    base = read_file(path)
    data = Table(base, str(path), "", VEHICLE_FILE_KEYS).data
    for name, keys in VEHICLE_PARTS.items():
        Table(data.get(name, {}), str(path), f"[{name}]", keys)
    return base


def _build(table: Table, notes: list[str], magnetorquers_alone: bool) -> Spacecraft:
    table.require("inertia_kgm2")
    if "wheels" not in table and "thrusters" not in table:
        if "magnetorquers" in table and not magnetorquers_alone:
            table.fail(
                "wheels",
                "missing, and magnetorquers alone do not fly such manoeuvres",
                "add [vehicle.wheels] or [vehicle.thrusters]",
            )
        if "magnetorquers" not in table:
            table.require("wheels")
    name = table.text("name", "spacecraft")
    table.text("title", " ")
    table.text("source", " ")
    faults = Faults()
    faults.of(_inertia, table)
    wheels = faults.of(read_wheels, table, notes)
    parts = (
        wheels,
        name,
        faults.of(read_thrusters, table),
        faults.of(read_magnetorquers, table, notes),
        faults.of(read_panels, table),
        faults.of(read_battery, table),
        faults.of(read_loads, table),
    )
    craft = faults.of(_assembled, table, notes, *parts)
    faults.refuse()
    return craft


def _inertia(table: Table) -> None:
    """Refuse an inertia that no body can have, whatever is wrong with the other parts."""
    checked(table, lambda: checked_inertia(table.data["inertia_kgm2"], []))


def _assembled(table: Table, notes: list[str], *parts: Any) -> Spacecraft:
    try:
        return create(table.data["inertia_kgm2"], *parts, notes=notes)
    except FieldError as error:
        if error.field == "torque_directions":
            part(table, "thrusters").fail(error.field, *error.problem_and_mend)
        table.fail(TOML_NAMES[error.field], *error.problem_and_mend)
