"""Find the line of a TOML file on which a key stands."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from jaxatt.problems.reading.documents import text_of
from jaxatt.problems.reading.fields import ScenarioError

_HEADER = re.compile(r"\s*(\[\[?)([^\[\]]+)\]\]?\s*(#.*)?$")
_KEY = re.compile(r"\s*([A-Za-z0-9_.\"' -]+?)\s*=")
_LONG = re.compile(r'"""|\'\'\'')
_LABEL = re.compile(r"\[+([^\]]*)\]+(?: no\. (\d+))?")


def located(error: ScenarioError) -> str:
    """The message of an error, with the line of the file, FILE:LINE, where that can be found."""
    message = str(error)
    if not error.origin or not Path(error.origin).is_file():
        return message
    line = line_of(text_of(Path(error.origin)), error.label, error.key)
    if line is None:
        return message
    return f"{error.origin}:{line}{message.removeprefix(error.origin)}"


def line_of(text: str, label: str, key: str) -> int | None:
    """Line, counted from 1, of a key in the table that messages call `label`.

    That of the table where it does not have the key; None where there is no such table.
    """
    found = _LABEL.match(label)
    table, number = (found[1], int(found[2] or 0)) if found else ("", 0)
    # After the brackets come keys whose values are tables in braces.
    within = label[found.end() :].split() if found else []
    inner = [part for part in within if not part.startswith('"')]
    wanted = inner[0] if inner else key
    of_table = None
    for line, (at, index), name in _entries(text):
        here = at == table and number in (0, index)
        if (here and name == wanted) or (not number and _join(at, name) == _join(table, wanted)):
            return line
        if of_table is None and ((here and not name) or _join(at, name) == table):
            of_table = line
    return of_table


def _join(table: str, key: str) -> str:
    return ".".join(part for part in (table, key) if part)


def _entries(text: str) -> Iterator[tuple[int, tuple[str, int], str]]:
    """Line, table with its number among those of its name, and key of every header and key."""
    table, counts = ("", 0), Counter[str]()
    long = False
    for line, content in enumerate(text.splitlines(), 1):
        inside = long
        long ^= len(_LONG.findall(content)) % 2 == 1
        if inside:
            continue
        if header := _HEADER.match(content):
            name = ".".join(part.strip(" \"'") for part in header[2].split("."))
            counts[name] += header[1] == "[["
            table = (name, counts[name])
            yield line, table, ""
        elif key := _KEY.match(content):
            yield line, table, key[1].strip("\"'")
