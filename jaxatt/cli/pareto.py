"""Command `jaxatt pareto`."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from jaxatt.cli.common import (
    NOT_REACHED,
    complain,
    computing,
    finish,
    numbers,
    prepared,
)
from jaxatt.cli.options import (
    FAILED_WHEELS,
    Cache,
    Case,
    Coordinator,
    FailedWheels,
    JoinTimeout,
    NoCache,
    Out,
    Process,
    Processes,
    Quiet,
    Seed,
    Starts,
)
from jaxatt.runtime.joining import JOIN_S, Joining, writes
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.pareto import POINTS, STARTS, front_request
from jaxatt.studies.pareto import pareto as find


class Over(StrEnum):
    """What the energy is weighed against."""

    time = "time"
    error = "error"


def pareto(
    case: Case,
    over: Annotated[
        Over,
        typer.Option(help="What the energy is weighed against: time, or the error at the end."),
    ] = Over.time,
    points: Annotated[
        int | None, typer.Option(help="Number of points.", show_default=str(POINTS))
    ] = None,
    values: Annotated[
        str | None,
        typer.Option(
            help="In place of the points, separated by commas: final times in seconds, or weights "
            "of time where the final time is free; over the error, weights of the attitude in "
            "joules.",
            show_default=False,
        ),
    ] = None,
    starts: Starts = None,
    seed: Seed = None,
    failed_wheel: FailedWheels = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    coordinator: Coordinator = None,
    processes: Processes = None,
    process: Process = None,
    join_timeout: JoinTimeout = JOIN_S,
    quiet: Quiet = False,
) -> None:
    """Compute the Pareto front of a manoeuvre's energy against time or against its error."""
    with computing(compile_cache, no_cache):
        given = None if values is None else numbers(values, "--values")
        asked = front_request(over, points, given)
        joining = Joining(coordinator, processes, process, join_timeout)
        scenario, folder = prepared(case, {FAILED_WHEELS: failed_wheel}, out, joining)
        flown = asked.points * (starts or min(STARTS, scenario.solver.starts))
        with Reporter(flown, quiet or not writes()) as report:
            found = find(
                scenario,
                over,
                points=points,
                values=given,
                starts=starts,
                seed=seed,
                report=report,
            )
        if writes():
            finish(repr(found), lambda: found.save(folder), folder, quiet, found.table())
            if not found.reached:
                complain("a point does not reach what was asked when flown")
        if not found.reached:
            raise typer.Exit(NOT_REACHED)
