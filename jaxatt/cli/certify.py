"""Command `jaxatt certify`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, computing, finish, prepared
from jaxatt.cli.options import Cache, Case, NoCache, Objective, Out, Quiet, Seed, Starts
from jaxatt.pipeline.certify import MOST_SUPPORTS
from jaxatt.pipeline.certify import certify as run
from jaxatt.runtime.progress import Reporter


def certify(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    objective: Objective = None,
    most: Annotated[
        int | None,
        typer.Option(
            min=1, help="Supports of one size that are tried at most.", show_default="50000"
        ),
    ] = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Solve, then try every support with fewer active intervals, and all with as many."""
    changes = {
        "solver.starts": starts,
        "solver.seed": seed,
        "objective.kind": objective,
    }
    with computing(compile_cache, no_cache):
        scenario, folder = prepared(case, changes, out)

        with Reporter(scenario.solver.starts, quiet) as report:
            certificate = run(scenario, most=most or MOST_SUPPORTS, report=report)
        sentences = certificate.sentences()
        finish(
            " ".join(sentences),
            lambda: certificate.save(folder),
            folder,
            quiet,
            certificate.table(),
            sentences,
        )
        if not certificate.result.reached:
            raise typer.Exit(NOT_REACHED)
