"""Refuse a file before the command that takes it is loaded, with all that it computes with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from jaxatt.cli.commands import TAKES
from jaxatt.cli.common import clean_exit
from jaxatt.problems.reading.checking import refuse
from jaxatt.problems.reading.documents import read_file
from jaxatt.studies.file_kinds import faults_of


def refuse_early(command: str, arguments: Sequence[str]) -> None:
    """Leave with all faults of a command's file, if it has any that are told without computing."""
    if command not in TAKES or not arguments or "--help" in arguments:
        return
    path = Path(arguments[0])
    if path.suffix != ".toml" or not path.is_file():
        return
    with clean_exit():
        refuse(faults_of(read_file(path), str(path), TAKES[command]))
