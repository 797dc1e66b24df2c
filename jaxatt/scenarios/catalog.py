"""Load a scenario by its bundled name or from a file."""

from __future__ import annotations

import os
from pathlib import Path

from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.scenario import Scenario
from jaxatt.scenarios.bundled import kind_of, names, suggestion, text
from jaxatt.scenarios.flight_loader import flight_from_mapping, load_flight_file
from jaxatt.scenarios.flight_model import FlightScenario
from jaxatt.scenarios.loader import from_mapping, load_file

_COMMANDS = {"manoeuvre": "solve", "flight": "simulate", "study": "sweep", "design": "design"}
"""Command that takes a bundled file of a kind."""


def load(name_or_path: str | Path) -> Scenario:
    """Return the bundled manoeuvre of this name, or the one in a TOML file.

    A bundled name comes first; write ``./NAME`` for a file that is called the same.

    Raises
    ------
    ScenarioError
        Neither exists, or the file cannot be used.
    """
    wanted = str(name_or_path)
    if wanted in names("manoeuvre"):
        origin = f"{wanted}.toml"
        return from_mapping(parse(text(wanted), origin), origin=origin)
    if _is_file(name_or_path):
        return load_file(Path(name_or_path))
    raise _neither(wanted, "manoeuvre", "scenario")


def load_flight(name_or_path: str | Path) -> FlightScenario:
    """Return the bundled flight of this name, or the one in a TOML file; as `load`."""
    wanted = str(name_or_path)
    if wanted in names("flight"):
        origin = f"{wanted}.toml"
        return flight_from_mapping(parse(text(wanted), origin), origin=origin)
    if _is_file(name_or_path):
        return load_flight_file(Path(name_or_path))
    raise _neither(wanted, "flight", "flight")


def _is_file(name_or_path: str | Path) -> bool:
    return Path(name_or_path).suffix == ".toml" or os.path.isfile(name_or_path)


def _neither(wanted: str, kind: str, word: str) -> ScenarioError:
    if os.path.isdir(wanted):
        return ScenarioError(f"{wanted}: is a folder; name a file in it, such as scenario.toml")
    other = kind_of(wanted)
    if other in _COMMANDS and other != kind:
        return ScenarioError(f"{wanted}: is a bundled {other}; use jaxatt {_COMMANDS[other]}")
    hint = suggestion(wanted, kind)
    return ScenarioError(f"{wanted}: neither a bundled {word} nor a file; {hint}")
