"""Refuse a file before the command that takes it is loaded, with all that it computes with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jaxatt.cli.commands import TAKES
from jaxatt.cli.common import clean_exit
from jaxatt.problems.reading.checking import refuse
from jaxatt.problems.reading.documents import read_file
from jaxatt.studies.file_kinds import faults_of, kind_of_document


def refuse_early(command: str, arguments: Sequence[str]) -> None:
    """Leave with all faults of a command's file, if it has any that are told without computing.

    A file of another kind than the command takes is left to the command.
    """
    paths = (Path(each) for each in arguments if each.endswith(".toml"))
    path = next((each for each in paths if each.is_file()), None)
    if path is None or "--help" in arguments:
        return
    with clean_exit():
        document = read_file(path)
        if kind_of_document(document) == TAKES[command]:
            refuse(faults_of(document, str(path), TAKES[command], path.parent))
