"""Command `jaxatt sparsity`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import computing, finish, prepared
from jaxatt.cli.options import Cache, Case, NoCache, Out, Quiet
from jaxatt.problems.reading.tables.manoeuvre import MOST_STARTS
from jaxatt.runtime.progress import Reporter
from jaxatt.studies.relative_sparsity import relative_sparsity
from jaxatt.studies.sparsity_table import sparsity_table


def sparsity(
    case: Case,
    starts: Annotated[int, typer.Option(min=1, max=MOST_STARTS, help="Starts of every case.")] = 16,
    intervals: Annotated[
        str, typer.Option(help="Numbers of control intervals, separated by commas.")
    ] = "15,30,45,60,90,120",
    limits: Annotated[
        str, typer.Option(help="Multiples of the torque limit, separated by commas.")
    ] = "0.4,0.5,0.65,0.8,1,1.5,2",
    out: Out = None,
    compile_cache: Cache = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Compute relative sparsity against intervals and torque limit, with a lower bound."""
    with computing(compile_cache, no_cache):
        scenario, folder = prepared(case, {}, out)
        counts, factors = _numbers("--intervals", intervals), _numbers("--limits", limits)
        if not all(count >= 2 and count == int(count) for count in counts):
            raise typer.BadParameter(f"{intervals}: give whole numbers of at least 2")

        with Reporter(starts, quiet) as report:
            study = relative_sparsity(
                scenario, [int(count) for count in counts], factors, starts, report
            )
        table = sparsity_table(study.to_dict())
        finish(repr(study), lambda: study.save(folder), folder, quiet, table)


def _numbers(option: str, text: str) -> list[float]:
    """Read positive numbers separated by commas."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(f"{text}: give numbers separated by commas") from None
    if not all(0.0 < number < float("inf") for number in numbers):
        raise typer.BadParameter(f"{option} {text}: every number must be greater than 0")
    return numbers
