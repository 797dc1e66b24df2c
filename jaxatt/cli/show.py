"""Command `jaxatt show`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import clean_exit, finish
from jaxatt.cli.options import Quiet
from jaxatt.runtime.files import prepare_folder
from jaxatt.studies.stored import open_study


def show(
    store: Annotated[Path, typer.Argument(metavar="STORE", help="Store of a sweep or of a map.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the figure.", show_default="the store's")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Print and draw what the store of a sweep or of a map holds so far."""
    with clean_exit():
        found = open_study(store)
        folder = prepare_folder(out or store.parent)
        finish(repr(found), lambda: found.save(folder), folder, quiet, found.table())
