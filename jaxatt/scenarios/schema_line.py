"""Where editors find the JSON schema of a TOML file: said in its first line."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parent / "schemas"
"""Where the schemas stand in the package."""


def schema_line(kind: str) -> str:
    """First line of a file of a kind, for editors; empty for one that has no schema."""
    file = FOLDER / f"{kind}.json"
    return f"#:schema {file.as_uri()}\n" if file.is_file() else ""
