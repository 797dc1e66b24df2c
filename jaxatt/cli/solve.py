"""Command `jaxatt solve`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import (
    NOT_REACHED,
    complain,
    computing,
    finish_result,
    prepared,
    shortfall,
)
from jaxatt.cli.meanwhile import loading
from jaxatt.cli.options import (
    FAILED_WHEELS,
    Cache,
    Case,
    Coordinator,
    Drawn,
    FailedWheels,
    JoinTimeout,
    NoCache,
    Objective,
    Out,
    Process,
    Processes,
    Quiet,
    Seed,
    Starts,
    Terminal,
)
from jaxatt.pipeline.solve import solve as find
from jaxatt.report.do_nothing import do_nothing_sentence
from jaxatt.report.plots import Figures
from jaxatt.runtime.joining import JOIN_S, Joining, writes
from jaxatt.runtime.progress import Reporter


def solve(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    terminal: Annotated[
        Terminal | None,
        typer.Option(help="Reach the target, or minimise the printed cost.", show_default=False),
    ] = None,
    objective: Objective = None,
    failed_wheel: FailedWheels = None,
    figures: Drawn = Figures.overview,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    coordinator: Coordinator = None,
    processes: Processes = None,
    process: Process = None,
    join_timeout: JoinTimeout = JOIN_S,
    quiet: Quiet = False,
) -> None:
    """Find the sparsest or shortest manoeuvre, fly it again, write summary and figures."""
    changes = {
        "solver.starts": starts,
        "solver.seed": seed,
        "objective.terminal": None if terminal is None else terminal.value,
        "objective.kind": objective,
        FAILED_WHEELS: failed_wheel,
    }
    with computing(compile_cache, no_cache):
        joining = Joining(coordinator, processes, process, join_timeout)
        scenario, folder = prepared(case, changes, out, joining)
        with Reporter(scenario.solver.starts, quiet or not writes()) as report:
            result = find(scenario, report=loading(report, _needed_at_the_end(figures)))
        if writes():
            finish_result(result, folder, figures, quiet)
            if not result.reached:
                # The table ends with this sentence already.
                sentence = do_nothing_sentence(result) if quiet else ""
                complain(f"{sentence} {shortfall(result)}".strip())
        if not result.reached:
            raise typer.Exit(NOT_REACHED)


def _needed_at_the_end(figures: Figures) -> tuple[str, ...]:
    """Modules that the process that writes the answer needs for it."""
    if not writes():
        return ()
    drawing = () if figures is Figures.none else ("jaxatt.drawing.picture",)
    return ("h5netcdf", "xarray", *drawing)
