"""Find the orbit of a scenario, a flight or a file of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jaxatt.environment.orbit_data.formats import kind_of as form_of
from jaxatt.environment.orbit_data.formats import text_of
from jaxatt.environment.orbit_data.path import OrbitDataError
from jaxatt.problems.reading.dates import read_epoch
from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.fields import ScenarioError, Table
from jaxatt.problems.reading.orbit import read_orbit
from jaxatt.problems.scenario import Orbit
from jaxatt.scenarios import bundled

_FORMS = "a TLE, an OMM, an OEM, or a scenario or flight in TOML"


@dataclass(frozen=True, eq=False)
class KnownOrbit:
    """An orbit, and what is to be said about it.

    name : for folders.  title : for people.  data : its table [orbit].  origin : the file.
    notes : sentences, such as that its elements are old.
    """

    name: str
    title: str
    orbit: Orbit
    data: Mapping[str, Any]
    origin: str
    notes: tuple[str, ...]


def known_orbit(case: str | Path, wanted: str = "", epoch: str = "") -> KnownOrbit:
    """The orbit of a bundled scenario or flight, or of a file.

    wanted : name or number of an object, in a file of several.
    epoch : the moment to start at, as text; "" for the one that the file says.
    Raises `ScenarioError`.
    """
    name = str(case)
    if bundled.kind_of(name) in ("manoeuvre", "flight"):
        return _of_scenario(parse(bundled.text(name), name), f"{name}.toml", None, epoch)
    path = Path(case)
    try:
        text = text_of(path)
    except OrbitDataError as error:
        known = bundled.suggestion(name, "manoeuvre", "flight")
        raise ScenarioError(f"{name}: {error}; or name a scenario: {known}") from None
    form = form_of(text)
    if form is None and path.suffix == ".toml":
        return _of_scenario(parse(text, name), name, path.parent, epoch)
    if form is None:
        raise ScenarioError(f"{name}: is no orbit that is known; give {_FORMS}")
    data = {f"{form}_file": path.name}
    if wanted:
        data["object"] = wanted
    return _known(path.stem, "", data, name, path.parent, epoch)


def _of_scenario(
    document: Mapping[str, Any], origin: str, folder: Path | None, epoch: str
) -> KnownOrbit:
    data = document.get("orbit")
    if not isinstance(data, dict):
        raise ScenarioError(f"{origin}: [orbit]: there is none; add one")
    around = document.get("environment", {})
    if isinstance(around, dict) and "epoch" in around and not epoch:
        epoch = around["epoch"]  # a flight has it there
    name = str(document.get("name", Path(origin).stem))
    title = str(document.get("title", name))
    return _known(name, title, data, origin, folder, epoch)


def _known(
    name: str, title: str, data: dict[str, Any], origin: str, folder: Path | None, epoch: str
) -> KnownOrbit:
    if epoch:
        data = {**data, "epoch": epoch}
    notes: list[str] = []
    days = None
    if "epoch" in data:
        days = read_epoch(Table({"epoch": data["epoch"]}, origin, "[orbit]", ("epoch",)))
    orbit = read_orbit(data, origin, folder, notes, days)
    if orbit.days is None:
        raise ScenarioError(
            f"{origin}: [orbit] epoch: missing, and nobody knows where Earth and sun are without "
            'it; add epoch = "2026-06-21T12:00:00Z", or --epoch 2026-06-21T12:00:00Z'
        )
    title = title or getattr(orbit.path, "title", name)
    return KnownOrbit(name, title, orbit, data, origin, tuple(notes))
