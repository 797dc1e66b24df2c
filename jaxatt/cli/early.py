"""Refuse a file before the command that takes it is loaded, with all that it computes with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jaxatt.cli.commands import TAKES
from jaxatt.cli.common import clean_exit
from jaxatt.problems.reading.checking import refuse
from jaxatt.problems.reading.documents import read_file
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.studies.file_kinds import faults_of, kind_of_document

_MENDS = {
    "manoeuvre": "use jaxatt solve",
    "flight": "use jaxatt simulate",
    "study": "use jaxatt sweep",
    "design": "use jaxatt design",
    "vehicle": "name it in one, by file = ... under [vehicle]",
}
"""What to do with a file of each kind."""


def refuse_early(command: str, arguments: Sequence[str]) -> None:
    """Leave with all faults of a command's file, if it has any that are told without computing.

    A file of another kind is refused where it is sound, but for what can be varied: `sweep` and
    `design` say themselves how.
    """
    paths = (Path(each) for each in arguments if each.endswith(".toml"))
    path = next((each for each in paths if each.is_file()), None)
    if path is None or "--help" in arguments:
        return
    with clean_exit():
        document = read_file(path)
        kind, wanted = kind_of_document(document), TAKES[command]
        faults = faults_of(document, str(path), kind, path.parent)
        if kind == wanted:
            refuse(faults)
        elif not faults and wanted in ("manoeuvre", "flight"):
            raise ScenarioError(f"{path}: describes a {kind}, not a {wanted}; {_MENDS[kind]}")
