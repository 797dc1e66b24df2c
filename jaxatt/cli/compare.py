"""Command `jaxatt compare`."""

from __future__ import annotations

import os
from pathlib import Path

import typer

from jaxatt.cli.common import (
    NOT_REACHED,
    complain,
    computing,
    finish,
    prepared,
    shortfall,
)
from jaxatt.cli.options import Cache, Case, NoCache, Out, Quiet, Seed, Starts
from jaxatt.problems.reading.documents import read_file
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.scenarios import kind_of, load_flight
from jaxatt.studies.compare import compare as run
from jaxatt.studies.flight_comparison import compare_flight
from jaxatt.studies.imaging import compare_imaging


def compare(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Run every controller, law or transcription of a case beside its printed values."""
    with computing(compile_cache, no_cache):
        kind = _kind(case)
        if kind == "imaging":
            _compare_imaging(case, out, quiet)
            return
        if kind == "flight":
            _compare_flight(case, seed, out, quiet)
            return
        scenario, folder = prepared(case, {"solver.starts": starts, "solver.seed": seed}, out)

        with Reporter(scenario.solver.starts, quiet) as report:
            comparison = run(scenario, starts, seed, report)
        finish(repr(comparison), lambda: comparison.save(folder), folder, quiet, comparison.table())
        if not comparison.reached:
            for kind, result in comparison.results.items():
                if not result.reached:
                    complain(f"{kind}: {shortfall(result)}")
            raise typer.Exit(NOT_REACHED)


def _kind(case: str) -> str:
    """Kind of case that a name or file describes; a file with laws is a flight."""

    known = kind_of(case)
    if known is not None:
        return known
    has_laws = os.path.isfile(case) and "laws" in read_file(Path(case))
    return "flight" if has_laws else "manoeuvre"


def _compare_flight(case: str, seed: int | None, out: Path | None, quiet: bool) -> None:

    flight = load_flight(case)
    folder = prepare_folder(out or Path("results") / flight.name)
    with Reporter(len(flight.laws), quiet) as report:
        comparison = compare_flight(flight, seed, report)
    finish(repr(comparison), lambda: comparison.save(folder), folder, quiet, comparison.table())


def _compare_imaging(case: str, out: Path | None, quiet: bool) -> None:

    folder = prepare_folder(out or Path("results") / case)

    found = compare_imaging()
    finish(repr(found), lambda: found.save(folder), folder, quiet, found.table())
