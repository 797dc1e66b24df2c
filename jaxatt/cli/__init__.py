"""The command line, one command a file.

Exit codes: 0 when every phase verifiably reached its target or every run flew to the end, 2 for bad
input or where output cannot be written, 3 when an answer does not reach or a run failed, 4 when
another process of the same computation is lost, 130 when interrupted.
"""

from __future__ import annotations

import gc
import importlib.metadata
import warnings
from typing import Annotated, Any

import typer

from jaxatt.cli.commands import Commands

_GARBAGE = (100_000, 50, 100)
"""Thresholds of the garbage collector. Programs and figures are made of many small objects that
live on; looking through all of them again and again costs a tenth of a command's time."""

app = typer.Typer(
    name="jaxatt",
    cls=Commands,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _tell_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"jaxatt {importlib.metadata.version('jaxatt')}")
        raise typer.Exit


@app.callback()
def jaxatt(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_tell_version, is_eager=True, help="Say the version and exit."
        ),
    ] = False,
) -> None:
    """Spacecraft attitude manoeuvres that touch the actuators least."""


def main() -> None:
    """Entry point of the `jaxatt` command."""
    warnings.formatwarning = _one_line
    gc.set_threshold(*_GARBAGE)
    app()


def _one_line(message: Warning | str, *_: Any, **__: Any) -> str:
    """A warning without the line of code that it comes from."""
    return f"Warning: {' '.join(str(message).split())}\n"
