"""Command `jaxatt check`."""

from __future__ import annotations

import pkgutil
from pathlib import Path
from typing import Annotated, Any

import typer

from jaxatt.cli.common import BAD_INPUT, clean_exit, refused, say
from jaxatt.problems.reading.checking import refuse
from jaxatt.problems.reading.documents import read_file
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.studies.file_kinds import faults_of, kind_of_document

_LOADERS = {
    "manoeuvre": "jaxatt.scenarios.loader:load_file",
    "flight": "jaxatt.scenarios.flight_loader:load_flight_file",
    "study": "jaxatt.studies.sweep.reading:load_study",
    "design": "jaxatt.studies.design.reading:load_design",
    "vehicle": "jaxatt.problems.reading.vehicles:load_vehicle_file",
}
"""Function that reads each kind of file; loaded for what takes computing only."""


def check(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="TOML files of any kind.")],
) -> None:
    """Say all that is wrong with TOML files, or what they describe."""
    good = True
    with clean_exit():
        for path in files:
            try:
                say(f"{path}: {_described(path)}")
            except ScenarioError as error:
                good = False
                refused(error)
    if not good:
        raise typer.Exit(BAD_INPUT)


def _described(path: Path) -> str:
    """What a file describes; raises `ScenarioError` with all that is told of its faults."""
    document = read_file(path)
    kind = kind_of_document(document)
    refuse(faults_of(document, str(path), kind, path.parent))
    loaded: Any = pkgutil.resolve_name(_LOADERS[kind])(path)
    title = getattr(loaded, "title", None) or document.get("title", loaded.name)
    objective = getattr(loaded, "objective", None)
    of = f' of kind "{objective.kind}"' if objective is not None else ""
    word = "sweep" if kind == "study" else kind
    return f"{word}{of}: {title}"
