"""Command `jaxatt design`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, clean_exit, complain, finish, prepare_jax
from jaxatt.cli.options import Cache, Out, Quiet
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.design.search import design as find
from jaxatt.studies.design.study import load_design

_MOST = 40


def design(
    study: Annotated[str, typer.Argument(metavar="FILE", help="A TOML file of a design study.")],
    most: Annotated[
        int, typer.Option("--most", min=1, help="Designs that may be tried, about.")
    ] = _MOST,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Choose numbers of a scenario by descent: torque limits, mountings, sizes of wheels."""
    with clean_exit():
        read = load_design(study)
        folder = prepare_folder(out or Path("results") / read.name)
        prepare_jax(compile_cache)
        with Reporter(most, quiet) as report:
            found = find(read, most=most, report=report)
        finish(repr(found), found.save(folder), folder, quiet, found.table())
        if not found.reached:
            complain("a case of the best design does not reach what was asked when flown")
            raise typer.Exit(NOT_REACHED)
