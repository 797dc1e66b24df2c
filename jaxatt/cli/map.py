"""Command `jaxatt map`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import (
    INTERRUPTED,
    NOT_REACHED,
    clean_exit,
    complain,
    finish,
    prepare_jax,
    say,
)
from jaxatt.cli.options import Cache, Case, Objective, Out, Quiet, Seed, Starts, Task, read_share
from jaxatt.report.store.names import store_name
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.attitude_map.map import attitude_map, prepared_scenario
from jaxatt.studies.attitude_map.targets import map_targets


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
    quiet: Quiet = False,
) -> None:
    """Map fewest intervals, least time or most energy over all turns from the initial attitude.

    The targets take the place of the scenario's own.  A run that is killed goes on where it was.
    """
    with clean_exit():
        share = read_share(task)
        scenario = prepared_scenario(case, objective, starts, seed)
        map_targets(scenario, targets)
        folder = prepare_folder(out or Path("results") / f"{scenario.name}-map")
        path = folder / store_name(f"{scenario.name}-map", share)
        prepare_jax(compile_cache)
        try:
            with Reporter(targets, quiet) as report:
                found = attitude_map(
                    case,
                    targets,
                    path,
                    objective=objective,
                    starts=starts,
                    seed=seed,
                    share=share,
                    report=report,
                )
        except KeyboardInterrupt:
            complain(
                f"Interrupted; what is done stays in {path}, and the same command goes on from it."
            )
            raise typer.Exit(INTERRUPTED) from None
        if share != (0, 1):
            say(f"Task {task}: {found!r}; jaxatt merge joins the stores of all tasks")
        else:
            finish(repr(found), [path, *found.save(folder)], folder, quiet, found.table())
        if not found.reached:
            complain(f"{found.missed} targets are not reached")
            raise typer.Exit(NOT_REACHED)
