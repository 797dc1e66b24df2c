"""The bundled scenarios."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from jaxatt.scenarios.documents import parse
from jaxatt.scenarios.fields import ScenarioError
from jaxatt.scenarios.loader import from_mapping, load_file
from jaxatt.scenarios.model import Scenario
from jaxatt.scenarios.schema import nearest


def _folder() -> Traversable:
    return resources.files("jaxatt.scenarios") / "data"


def names() -> tuple[str, ...]:
    """Return the names of the bundled scenarios."""
    files = (entry.name for entry in _folder().iterdir())
    return tuple(sorted(name[:-5] for name in files if name.endswith(".toml")))


def titles() -> dict[str, str]:
    """Return the one-line title of each bundled scenario by its name."""
    return {name: str(parse(text(name), name).get("title", name)) for name in names()}


def text(name: str) -> str:
    """Return the TOML text of a bundled scenario.

    Raises
    ------
    ScenarioError
        No such scenario; the nearest name is suggested.
    """
    if name not in names():
        raise ScenarioError(f"{name}: no bundled scenario; {_suggestion(name)}")
    return (_folder() / f"{name}.toml").read_text(encoding="utf-8")


def load(name_or_path: str | Path) -> Scenario:
    """Return a bundled scenario by name, or the one in a TOML file.

    A bundled name comes first; write ``./NAME`` for a file that is called the same.

    Raises
    ------
    ScenarioError
        Neither exists, or the file cannot be used.
    """
    wanted = str(name_or_path)
    if wanted in names():
        origin = f"{wanted}.toml"
        return from_mapping(parse(text(wanted), origin), origin=origin)
    path = Path(name_or_path)
    if path.suffix == ".toml" or path.is_file():
        return load_file(path)
    raise ScenarioError(f"{wanted}: neither a bundled scenario nor a file; {_suggestion(wanted)}")


def _suggestion(name: str) -> str:
    near = nearest(name, names())
    hint = f"did you mean '{near}'? " if near else ""
    return f"{hint}`jaxatt scenarios` lists the bundled ones"
