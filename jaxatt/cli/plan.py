"""Command `jaxatt plan`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, computing, finish, finish_result, prepared
from jaxatt.cli.options import (
    FAILED_WHEELS,
    Cache,
    Case,
    Coordinator,
    Drawn,
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
from jaxatt.pipeline.solve import solve
from jaxatt.report.plots import Figures
from jaxatt.runtime.joining import JOIN_S, Joining, writes
from jaxatt.runtime.progress import Reporter
from jaxatt.scenarios import Scenario, ScenarioError
from jaxatt.studies.plan_year import STARTS, plan_year
from jaxatt.studies.year_dates import read_dates


def plan(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    joint: Annotated[
        bool | None,
        typer.Option(
            "--joint/--sequence",
            help="Improve all tasks together after they were solved one after the other, or not.",
            show_default="the scenario's",
        ),
    ] = None,
    dates: Annotated[
        str | None,
        typer.Option(
            metavar="FIRST:LAST[:DAYS]",
            help="Plan on each of these dates, with the sun and the shadow of the date, and show "
            "what is gained over the year.",
            show_default=False,
        ),
    ] = None,
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
    """Plan tasks that earn the most energy, fly the plan, write summary, archive and figures."""
    changes = {
        "solver.starts": starts,
        "solver.seed": seed,
        "plan.joint": joint,
        FAILED_WHEELS: failed_wheel,
    }
    with computing(compile_cache, no_cache):
        joining = Joining(coordinator, processes, process, join_timeout)
        scenario, folder = prepared(case, changes, out, joining)
        if "tasks" not in scenario.document:
            raise ScenarioError(
                f"{scenario.name}: has no [[tasks]] to plan; use jaxatt solve, or add some"
            )
        if dates is not None:
            _over_dates(scenario, dates, starts, seed, folder, quiet)
            return
        with Reporter(scenario.solver.starts, quiet or not writes()) as report:
            result = solve(scenario, report=report)
        if writes():
            finish_result(result, folder, figures, quiet)
        if not result.reached:
            raise typer.Exit(NOT_REACHED)


def _over_dates(
    scenario: Scenario, dates: str, starts: int | None, seed: int | None, folder: Path, quiet: bool
) -> None:
    days = read_dates(dates, scenario)
    with Reporter(len(days) * (starts or STARTS), quiet or not writes()) as report:
        year = plan_year(scenario, days, starts=starts, seed=seed, report=report)
    if writes():
        finish(repr(year), lambda: year.save(folder), folder, quiet, year.table())
    if not year.reached:
        raise typer.Exit(NOT_REACHED)
