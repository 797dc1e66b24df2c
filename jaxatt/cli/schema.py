"""Command `jaxatt schema`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import clean_exit, say
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.schema import nearest
from jaxatt.runtime.files import filling, prepare_folder
from jaxatt.studies.json_schema import KINDS, schema_of
from jaxatt.studies.key_table import key_page


def schema(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help=f"Kind of file: {', '.join(KINDS)}.")
    ] = KINDS[0],
    page: Annotated[
        bool, typer.Option("--page", help="A page of all keys, in Markdown, in its place.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the schemas of all kinds.", show_default="print one"),
    ] = None,
) -> None:
    """Print the JSON schema of a kind of TOML file, for editors."""
    with clean_exit():
        if kind not in KINDS:
            near = nearest(kind, KINDS)
            hint = f"did you mean '{near}'? " if near else ""
            raise ScenarioError(f"{kind}: no kind of file; {hint}kinds: {', '.join(KINDS)}")
        if page:
            say(key_page(), newline=False)
        elif out is None:
            say(as_text(kind), newline=False)
        else:
            with filling(prepare_folder(out)) as partial:
                for each in KINDS:
                    (partial / f"{each}.json").write_text(as_text(each), encoding="utf-8")


def as_text(kind: str) -> str:
    """The schema of a kind as the text of its file."""
    return json.dumps(schema_of(kind), indent=1) + "\n"
