"""Command `jaxatt merge`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import clean_exit, say
from jaxatt.report.store.merge import merge as join


def merge(
    stores: Annotated[
        list[Path], typer.Argument(metavar="STORE...", help="Stores of the tasks of one study.")
    ],
    out: Annotated[Path, typer.Option(help="The store that they are joined in, made if missing.")],
) -> None:
    """Join the stores of the tasks of a job array into one."""
    with clean_exit():
        merged = join(stores, out)
        say(f"Written to {merged.path}: {merged.done} of {merged.samples} samples")
