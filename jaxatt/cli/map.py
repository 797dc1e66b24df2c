"""Command `jaxatt map`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, complain, computing
from jaxatt.cli.options import (
    Cache,
    Case,
    NoCache,
    Objective,
    Out,
    Quiet,
    Seed,
    Starts,
    Task,
    read_share,
)
from jaxatt.cli.stored import grown
from jaxatt.report.store.names import store_name
from jaxatt.runtime.files import prepare_folder
from jaxatt.studies.attitude_map.map import solve_map
from jaxatt.studies.attitude_map.study import map_study


def map_(
    case: Case,
    targets: Annotated[
        int, typer.Option(help="Number of targets, spread evenly over all turns.")
    ] = 1000,
    objective: Objective = None,
    task: Task = None,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Map fewest intervals, least time or most energy over all turns from the initial attitude.

    The targets take the place of the scenario's own.  A run that is killed goes on where it was.
    """
    with computing(compile_cache, no_cache):
        share = read_share(task)
        study = map_study(case, targets, objective, starts, seed)
        folder = prepare_folder(out or Path("results") / study.name)
        path = folder / store_name(study.name, share)
        count = study.layout().samples_of(share)
        found = grown(
            lambda report: solve_map(study, path, share, report), count, path, share, quiet
        )
        if not found.reached:
            complain(f"{found.missed} targets are not reached")
            raise typer.Exit(NOT_REACHED)
