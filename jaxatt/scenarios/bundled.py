"""TOML files that come with the package, grouped by kind."""

from __future__ import annotations

from importlib import resources
from importlib.resources.abc import Traversable

from jaxatt.problems.reading.documents import parse
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.schema import nearest

KINDS = {
    "manoeuvre": "data",
    "flight": "flights",
    "imaging": "imaging",
    "study": "studies",
    "design": "designs",
}
"""Folder of every kind: manoeuvres, flights of feedback laws, images of the ground, studies."""


def _folder(kind: str) -> Traversable:
    return resources.files("jaxatt.scenarios") / KINDS[kind]


def names(kind: str = "manoeuvre") -> tuple[str, ...]:
    """Return the names of the bundled scenarios of a kind, see `KINDS`."""
    files = (entry.name for entry in _folder(kind).iterdir())
    return tuple(sorted(name[:-5] for name in files if name.endswith(".toml")))


def kind_of(name: str) -> str | None:
    """Return the kind of a bundled scenario, or None for an unknown name."""
    return next((kind for kind in KINDS if name in names(kind)), None)


def titles(kind: str = "manoeuvre") -> dict[str, str]:
    """Return the one-line title of each bundled scenario of a kind by its name."""
    return {name: str(parse(text(name), name).get("title", name)) for name in names(kind)}


def text(name: str) -> str:
    """Return the TOML text of a bundled scenario of any kind.

    Raises
    ------
    ScenarioError
        No such scenario; the nearest name is suggested.
    """
    kind = kind_of(name)
    if kind is None:
        raise ScenarioError(f"{name}: no bundled scenario; {suggestion(name, *KINDS)}")
    return (_folder(kind) / f"{name}.toml").read_text(encoding="utf-8")


def suggestion(name: str, *kinds: str) -> str:
    """Sentence that suggests a bundled name close to an unknown one."""
    known = [each for kind in kinds for each in names(kind)]
    near = nearest(name, known)
    hint = f"did you mean '{near}'? " if near else ""
    return f"{hint}bundled: {', '.join(known)}"
