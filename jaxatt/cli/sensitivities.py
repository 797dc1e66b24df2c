"""Command `jaxatt sensitivities`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, complain, computing, finish, prepared
from jaxatt.cli.options import Cache, Case, NoCache, Out, Quiet, Seed, Starts
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.sensitivity.sensitivities import sensitivities as find


def sensitivities(
    case: Case,
    parameters: Annotated[
        str | None,
        typer.Option(
            help="Numbers of the scenario, separated by commas, such as "
            "vehicle.wheels.torque_limit_Nm; all that matter by default.",
            show_default=False,
        ),
    ] = None,
    phase: Annotated[
        int | None,
        typer.Option(help="Phase, from 1, of a scenario that has several.", show_default=False),
    ] = None,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Say how the answer of a scenario changes with the numbers of the scenario."""
    with computing(compile_cache, no_cache):
        scenario, folder = prepared(case, {}, out)
        names = None if parameters is None else [part.strip() for part in parameters.split(",")]
        with Reporter(starts or scenario.solver.starts, quiet) as report:
            found = find(scenario, names, starts=starts, seed=seed, phase=phase, report=report)
        finish(repr(found), lambda: found.save(folder), folder, quiet, found.table())
        if not found.regular:
            complain("the answer is not regular; the table says why, and which derivatives hold")
            raise typer.Exit(NOT_REACHED)
