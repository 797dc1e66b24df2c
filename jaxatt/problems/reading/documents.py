"""Read TOML text and files."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from jaxatt.problems.reading.fields import ScenarioError


def parse(text: str, origin: str) -> dict[str, Any]:
    """Return the document of a TOML text; a `ScenarioError` names the line of a syntax error."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(
            f"{origin}: not valid TOML: {error}; texts need quotes, numbers none, and each key "
            "may appear once in a table"
        ) from None


def read_file(path: Path) -> dict[str, Any]:
    """Return the document of a TOML file."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: is not a text file in UTF-8; save it as UTF-8") from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise ScenarioError(f"{path}: cannot be read ({reason}); check the path") from None
    return parse(text, str(path))
