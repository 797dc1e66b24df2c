"""Command `jaxatt simulate`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, complain, computing, finish
from jaxatt.cli.options import FAILED_WHEELS, Cache, FailedWheels, Flight, NoCache, Out, Quiet
from jaxatt.pipeline.simulate import simulate as run
from jaxatt.problems.reading.tables.manoeuvre import MOST_SEED
from jaxatt.report.flight_table import flight_table
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.scenarios import load_flight, replace_in_flight
from jaxatt.scenarios.flight_schema import MOST_RUNS


def simulate(
    case: Flight,
    law: Annotated[
        str | None,
        typer.Option(help="A law of the flight.", show_default="its first one"),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=MOST_RUNS,
            help="Runs, spread as the flight says.",
            show_default="the nominal one alone",
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(min=0, max=MOST_SEED, help="Seed of the runs.", show_default="the flight's"),
    ] = None,
    failed_wheel: FailedWheels = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Fly a feedback law, once or in a campaign of thousands of runs."""
    with computing(compile_cache, no_cache):
        flight = load_flight(case)
        if failed_wheel is not None:
            flight = replace_in_flight(flight, {FAILED_WHEELS: failed_wheel})
        folder = prepare_folder(out or Path("results") / flight.name)

        with Reporter(runs or 1, quiet) as report:
            result = run(flight, law, runs=runs, seed=seed, report=report)
        finish(repr(result), lambda: result.save(folder), folder, quiet, flight_table(result))
        if not result.sound.all():
            failed = {words: len(rows) for words, rows in result.failures.items()}
            complain(
                "; ".join(f"{number} of {result.runs}: {words}" for words, number in failed.items())
            )
            raise typer.Exit(NOT_REACHED)
