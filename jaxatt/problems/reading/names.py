"""Names in a file that become names of folders."""

from __future__ import annotations

import re
from pathlib import Path

from jaxatt.problems.reading.fields import Table

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,99}")


def read_name(top: Table) -> str:
    """Read the name of a document, which results are written under; by default its file's."""
    if "name" not in top:
        return Path(top.origin).stem
    name = top.text("name")
    check_folder_name(top, "name", name, "results/NAME")
    return name


def check_folder_name(table: Table, key: str, name: str, folder: str) -> None:
    """Refuse a name that cannot be that of a folder; folder : where it stands, for the message."""
    if not _NAME.fullmatch(name):
        table.fail(
            key,
            f"names the folder of the output, {folder}",
            "use at most 100 letters, digits, '-', '_' and '.', and begin with a letter or digit",
        )
