"""Command `jaxatt sweep`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import NOT_REACHED, clean_exit, complain, finish, numbers, prepare_jax
from jaxatt.cli.options import Cache, Out, Quiet, Seed, Starts
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.scenarios import load
from jaxatt.studies.effort_sweep import WEIGHTS, sweep_effort


def sweep(
    cases: Annotated[
        list[str], typer.Argument(help="Bundled scenarios or files of kind time-effort.")
    ],
    rho: Annotated[
        str | None,
        typer.Option(help="Weights of effort, separated by commas; 0.001 to 10 by default."),
    ] = None,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Compute time and effort against the weight of effort, and the front between the two."""
    with clean_exit():
        weights = None if rho is None else _weights(rho)

        loaded = [load(case) for case in cases]
        folder = prepare_folder(out or Path("results") / "-".join(case.name for case in loaded))
        prepare_jax(compile_cache)

        with Reporter(starts or loaded[0].solver.starts, quiet) as report:
            found = sweep_effort(loaded, weights or WEIGHTS, starts, seed, report)
        finish(repr(found), found.save(folder), folder, quiet, found.table())
        if not found.reached:
            complain("an optimum does not reach its target when flown")
            raise typer.Exit(NOT_REACHED)


def _weights(text: str) -> list[float]:
    """Read non-negative numbers separated by commas."""
    weights = numbers(text, "--rho")
    if not all(0.0 <= weight < float("inf") for weight in weights):
        raise typer.BadParameter(f"--rho {text}: a weight of effort must not be negative")
    return weights
