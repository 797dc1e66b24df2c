"""The vehicle of a scenario: bundled, in a file of its own, or written in place."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.scenarios.documents import parse, read_file
from jaxatt.scenarios.fields import Table
from jaxatt.scenarios.schema import (
    MAGNETORQUER_KEYS,
    SPACECRAFT_TABLES,
    VEHICLE_FILE_KEYS,
    WHEEL_KEYS,
    nearest,
)
from jaxatt.spacecraft import (
    FieldError,
    Magnetorquers,
    Spacecraft,
    create,
    magnetorquers,
    reaction_wheels,
)

_TOML_NAMES = {
    "axes": "axes",
    "inertia": "inertia_kgm2",
    "torque_limit": "torque_limit_Nm",
    "speed_limit": "speed_limit_rad_s",
    "dipole_limit": "dipole_limit_Am2",
}


def _folder() -> Traversable:
    return resources.files("jaxatt.spacecraft") / "vehicles"


def vehicle_names() -> tuple[str, ...]:
    """Return the names of the bundled vehicles."""
    files = (entry.name for entry in _folder().iterdir())
    return tuple(sorted(name[:-5] for name in files if name.endswith(".toml")))


def load_vehicle(name: str) -> Spacecraft:
    """Return a bundled vehicle, e.g. ``load_vehicle("hypso1")``."""
    return read_vehicle({"use": name}, "load_vehicle", None, [])


def read_vehicle(data: Any, origin: str, folder: Path | None, notes: list[str]) -> Spacecraft:
    """Return the checked vehicle of a [vehicle] table.

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
    """
    table = Table(data, origin, "[vehicle]", SPACECRAFT_TABLES["vehicle"])
    if "wheels" in table:
        Table(table.data["wheels"], origin, "[vehicle.wheels]", WHEEL_KEYS)
    if "use" in table and "file" in table:
        table.fail("file", "given beside use", "keep one of the two and drop the other")
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
    if "wheels" in base and "wheels" in overrides:
        merged["wheels"] = {**base["wheels"], **overrides["wheels"]}
    return _build(Table(merged, origin, "[vehicle]", VEHICLE_FILE_KEYS), notes)


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
    wheels = Table(base, str(path), "", VEHICLE_FILE_KEYS).data.get("wheels", {})
    Table(wheels, str(path), "[wheels]", WHEEL_KEYS)
    return base


def _build(table: Table, notes: list[str]) -> Spacecraft:
    table.require("inertia_kgm2", "[[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]")
    table.require("wheels", "{ axes = [...], ... }")
    wheels = Table(table.data["wheels"], table.origin, "[vehicle.wheels]", WHEEL_KEYS)
    rows = wheels.require("axes", "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]")
    if not isinstance(rows, list) or not all(isinstance(r, list) and len(r) == 3 for r in rows):
        wheels.fail("axes", "is not a list of axes", "give one row of three numbers for each wheel")
    for row in rows:
        if not all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in row):
            wheels.fail("axes", "holds something that is no number", "give plain numbers")
    wheels.require("inertia_kgm2", "2.1e-4")
    wheels.require("torque_limit_Nm", "3e-3")
    try:
        built = reaction_wheels(
            np.array(rows, dtype=np.float64).reshape(-1, 3).T,
            wheels.data["inertia_kgm2"],
            wheels.data["torque_limit_Nm"],
            wheels.data.get("speed_limit_rad_s", np.inf),
            notes=notes,
        )
    except FieldError as error:
        wheels.fail(_TOML_NAMES[error.field], *_split(error))
    name = table.text("name", "spacecraft")
    table.text("title", " ")
    table.text("source", " ")
    try:
        return create(table.data["inertia_kgm2"], built, name, _magnetorquers(table))
    except FieldError as error:
        table.fail(_TOML_NAMES[error.field], *_split(error))


def _magnetorquers(table: Table) -> Magnetorquers | None:
    if "magnetorquers" not in table:
        return None
    label = "[vehicle.magnetorquers]"
    inner = Table(table.data["magnetorquers"], table.origin, label, MAGNETORQUER_KEYS)
    try:
        return magnetorquers(inner.require("dipole_limit_Am2", "0.5"))
    except FieldError as error:
        inner.fail(_TOML_NAMES[error.field], *_split(error))


def _split(error: FieldError) -> tuple[str, str]:
    problem, _, mend = error.problem.partition("; ")
    return problem, mend
