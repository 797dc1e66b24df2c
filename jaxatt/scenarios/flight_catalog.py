"""The bundled flights."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from jaxatt.scenarios.documents import parse
from jaxatt.scenarios.fields import ScenarioError
from jaxatt.scenarios.flight_loader import flight_from_mapping, load_flight_file
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.scenarios.schema import nearest


def _folder() -> Traversable:
    return resources.files("jaxatt.scenarios") / "flights"


def flight_names() -> tuple[str, ...]:
    """Names of the bundled flights."""
    files = (entry.name for entry in _folder().iterdir())
    return tuple(sorted(name[:-5] for name in files if name.endswith(".toml")))


def flight_titles() -> dict[str, str]:
    """One-line title of each bundled flight by its name."""
    return {name: str(parse(flight_text(name), name).get("title", name)) for name in flight_names()}


def flight_text(name: str) -> str:
    """TOML text of a bundled flight; raises `ScenarioError` where there is none."""
    if name not in flight_names():
        near = nearest(name, flight_names())
        hint = f"did you mean '{near}'? " if near else ""
        raise ScenarioError(
            f"{name}: no bundled flight; {hint}bundled: {', '.join(flight_names())}"
        )
    return (_folder() / f"{name}.toml").read_text(encoding="utf-8")


def load_flight(name_or_path: str | Path) -> FlightScenario:
    """A bundled flight by name, or the one in a TOML file; raises `ScenarioError`."""
    wanted = str(name_or_path)
    if wanted not in flight_names() and (wanted.endswith(".toml") or Path(wanted).is_file()):
        return load_flight_file(wanted)
    return flight_from_mapping(parse(flight_text(wanted), wanted), origin=f"{wanted}.toml")
