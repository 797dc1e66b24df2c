"""Read TOML text and files."""

from __future__ import annotations

import codecs
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NoReturn

from jaxatt.problems.reading.fields import ScenarioError

_DEEPEST = 50
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def parse(text: str, origin: str) -> dict[str, Any]:
    """Return the document of a TOML text; a `ScenarioError` names the line of a syntax error."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(
            f"{origin}: not valid TOML: {error}; texts need quotes, numbers none, and each key "
            "may appear once in a table"
        ) from None
    except ValueError:
        # Python reads whole numbers up to some thousand digits.
        raise ScenarioError(
            f"{origin}: holds a whole number of too many digits; write it as 1e30, or shorter"
        ) from None
    except RecursionError:
        _refuse_depth(origin)
    level: list[Any] = [document]
    for _ in range(_DEEPEST):
        level = [item for outer in level for item in _items(outer)]
        if not level:
            return document
    _refuse_depth(origin)


def _items(value: Any) -> Iterable[Any]:
    return value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()


def _refuse_depth(origin: str) -> NoReturn:
    raise ScenarioError(
        f"{origin}: lists or tables are nested more than {_DEEPEST} deep; close each of them"
    )


def read_file(path: Path) -> dict[str, Any]:
    """Return the document of a TOML file, which is read as `text_of` does."""
    return parse(text_of(path), str(path))


def text_of(path: Path) -> str:
    """Return the text of a TOML file.

    In UTF-8, with or without a byte order mark, or in UTF-16 with one, as Windows writes them.
    """
    try:
        with path.open("rb") as file:
            encoding = "utf-16" if file.read(2) in _UTF_16 else "utf-8-sig"
        text = path.read_text(encoding=encoding)
    except UnicodeError:
        raise ScenarioError(f"{path}: is not a text file in UTF-8; save it as UTF-8") from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise ScenarioError(f"{path}: cannot be read ({reason}); check the path") from None
    except ValueError:
        raise ScenarioError(f"{str(path)!r}: is no path of a file; check the path") from None
    if "\0" in text:
        raise ScenarioError(
            f"{path}: holds NUL characters, as UTF-16 without a byte order mark does; save it as "
            "UTF-8"
        )
    return text
