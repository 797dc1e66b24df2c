"""Read the vehicle of a scenario: bundled, in a file of its own, or written in place."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np

from jaxatt.problems.reading.documents import parse, read_file
from jaxatt.problems.reading.fields import Table
from jaxatt.problems.reading.schema import (
    MAGNETORQUER_KEYS,
    SPACECRAFT_TABLES,
    THRUSTER_KEYS,
    VEHICLE_FILE_KEYS,
    WHEEL_KEYS,
    nearest,
)
from jaxatt.spacecraft import (
    FieldError,
    Magnetorquers,
    ReactionWheels,
    Spacecraft,
    Thrusters,
    create,
    magnetorquers,
    reaction_wheels,
    thrusters,
)
from jaxatt.spacecraft.checks import Float64

_TOML_NAMES = {
    "axes": "axes",
    "inertia": "inertia_kgm2",
    "torque_limit": "torque_limit_Nm",
    "speed_limit": "speed_limit_rad_s",
    "dipole_limit": "dipole_limit_Am2",
    "torque_directions": "torque_directions",
    "minimum_on_time": "minimum_on_time_s",
    "minimum_impulse": "minimum_impulse_Nms",
}
_ACTUATOR_KEYS = {
    "wheels": WHEEL_KEYS,
    "thrusters": THRUSTER_KEYS,
    "magnetorquers": MAGNETORQUER_KEYS,
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
    """
    table = Table(data, origin, "[vehicle]", SPACECRAFT_TABLES["vehicle"])
    for name, keys in _ACTUATOR_KEYS.items():
        if name in table:
            Table(table.data[name], origin, f"[vehicle.{name}]", keys)
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
    for name in _ACTUATOR_KEYS:
        if name in base and name in overrides:
            merged[name] = {**base[name], **overrides[name]}
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
    data = Table(base, str(path), "", VEHICLE_FILE_KEYS).data
    for name, keys in _ACTUATOR_KEYS.items():
        Table(data.get(name, {}), str(path), f"[{name}]", keys)
    return base


def _build(table: Table, notes: list[str]) -> Spacecraft:
    table.require("inertia_kgm2", "[[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]]")
    if "thrusters" not in table:
        table.require("wheels", "{ axes = [...], ... }")
    wheels = _wheels(table, notes) if "wheels" in table else None
    pushing = _thrusters(table) if "thrusters" in table else None
    name = table.text("name", "spacecraft")
    table.text("title", " ")
    table.text("source", " ")
    try:
        return create(table.data["inertia_kgm2"], wheels, name, pushing, _magnetorquers(table))
    except FieldError as error:
        if error.field == "torque_directions":
            _mounted(table, "thrusters").fail(error.field, *_split(error))
        table.fail(_TOML_NAMES[error.field], *_split(error))


def _wheels(table: Table, notes: list[str]) -> ReactionWheels:
    wheels = _mounted(table, "wheels")
    axes = _rows(wheels, "axes", "wheel")
    wheels.require("inertia_kgm2", "2.1e-4")
    wheels.require("torque_limit_Nm", "3e-3")
    try:
        return reaction_wheels(
            axes,
            wheels.data["inertia_kgm2"],
            wheels.data["torque_limit_Nm"],
            wheels.data.get("speed_limit_rad_s", np.inf),
            notes=notes,
        )
    except FieldError as error:
        wheels.fail(_TOML_NAMES[error.field], *_split(error))


def _thrusters(table: Table) -> Thrusters:
    pushing = _mounted(table, "thrusters")
    directions = _rows(pushing, "torque_directions", "thruster")
    pushing.require("torque_limit_Nm", "0.195")
    try:
        return thrusters(
            directions,
            pushing.data["torque_limit_Nm"],
            pushing.data.get("minimum_on_time_s", 0.0),
            pushing.data.get("minimum_impulse_Nms", 0.0),
        )
    except FieldError as error:
        pushing.fail(_TOML_NAMES[error.field], *_split(error))


def _mounted(table: Table, name: str) -> Table:
    return Table(table.data[name], table.origin, f"[vehicle.{name}]", _ACTUATOR_KEYS[name])


def _rows(table: Table, key: str, what: str) -> Float64:
    """Read a list with one row of three numbers for each actuator, as columns (3, n)."""
    rows = table.require(key, "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]")
    if not isinstance(rows, list) or not all(isinstance(r, list) and len(r) == 3 for r in rows):
        table.fail(key, f"is not a list of {key}", f"give one row of three numbers for each {what}")
    for row in rows:
        if not all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in row):
            table.fail(key, "holds something that is no number", "give plain numbers")
    return np.array(rows, dtype=np.float64).reshape(-1, 3).T


def _magnetorquers(table: Table) -> Magnetorquers | None:
    if "magnetorquers" not in table:
        return None
    inner = _mounted(table, "magnetorquers")
    try:
        return magnetorquers(inner.require("dipole_limit_Am2", "0.5"))
    except FieldError as error:
        inner.fail(_TOML_NAMES[error.field], *_split(error))


def _split(error: FieldError) -> tuple[str, str]:
    problem, _, mend = error.problem.partition("; ")
    return problem, mend
