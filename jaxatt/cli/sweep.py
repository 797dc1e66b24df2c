"""Command `jaxatt sweep`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, complain, computing
from jaxatt.cli.options import Cache, NoCache, Out, Quiet, Seed, Starts, Task, read_share
from jaxatt.cli.stored import grown
from jaxatt.report.store.names import store_name
from jaxatt.runtime.files import prepare_folder
from jaxatt.studies.sweep.reading import load_study
from jaxatt.studies.sweep.sweep import sweep as sweep_study


def sweep(
    study: Annotated[
        str, typer.Argument(metavar="STUDY", help="A bundled study or a TOML file of one.")
    ],
    task: Task = None,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Solve scenarios for many values of their numbers, sample by sample.

    A run that is killed goes on where it was.
    """
    with computing(compile_cache, no_cache):
        share = read_share(task)
        given = {"solver.starts": starts, "solver.seed": seed}
        chosen = load_study(
            study, {key: value for key, value in given.items() if value is not None}
        )
        for note in chosen.notes:
            complain(f"Note: {chosen.origin}: {note}")
        folder = prepare_folder(out or Path("results") / chosen.name)
        path = folder / store_name(chosen.name, share)
        count = chosen.layout().samples_of(share)
        found = grown(
            lambda report: sweep_study(chosen, path, share=share, report=report),
            count,
            path,
            share,
            quiet,
        )
        if not found.reached:
            missed, failed = found.missed, found.failed
            complain(f"{missed} samples do not reach their target, {failed} have no answer")
            raise typer.Exit(NOT_REACHED)
