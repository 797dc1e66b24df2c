"""Command `jaxatt design`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, complain, computing, finish
from jaxatt.cli.options import Cache, NoCache, Out, Quiet, Seed, Starts
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.design.design import design as find
from jaxatt.studies.design.reading import load_design


def design(
    case: Annotated[
        str, typer.Argument(metavar="STUDY", help="A bundled design study or a TOML file of one.")
    ],
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Choose numbers of a scenario by descent: torque limits, mountings, sizes of wheels.

    What is minimised is the objective of its answers, or a number under a limit of that objective.
    """
    with computing(compile_cache, no_cache):
        given = {"solver.starts": starts, "solver.seed": seed}
        study = load_design(case, {key: value for key, value in given.items() if value is not None})
        folder = prepare_folder(out or Path("results") / study.name)
        with Reporter(study.points, quiet) as report:
            found = find(study, report)
        finish(repr(found), lambda: found.save(folder), folder, quiet, found.table())
        if not found.reached:
            complain("an independent solve of the design does not confirm it; take more starts")
            raise typer.Exit(NOT_REACHED)
