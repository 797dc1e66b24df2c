"""Command `jaxatt sweep`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jaxatt.cli.common import (
    INTERRUPTED,
    NOT_REACHED,
    clean_exit,
    complain,
    finish,
    numbers,
    prepare_jax,
    say,
)
from jaxatt.cli.options import Cache, Out, Quiet, Seed, Starts, Task, read_share
from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.report.store.names import store_name
from jaxatt.runtime.files import prepare_folder
from jaxatt.runtime.progress import Reporter
from jaxatt.scenarios import load
from jaxatt.studies.effort_sweep import WEIGHTS, sweep_effort
from jaxatt.studies.sweep.reading import is_study, load_study
from jaxatt.studies.sweep.run import samples_of
from jaxatt.studies.sweep.sweep import Sweep
from jaxatt.studies.sweep.sweep import sweep as sweep_study


def sweep(
    cases: Annotated[
        list[str],
        typer.Argument(
            metavar="STUDY...",
            help="A bundled study or a TOML file of one; or scenarios of kind time-effort.",
        ),
    ],
    rho: Annotated[
        str | None,
        typer.Option(
            help="For scenarios of kind time-effort: weights of effort, separated by commas; 0.001 "
            "to 10 by default."
        ),
    ] = None,
    task: Task = None,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Solve a scenario for many values of its numbers, into a store that a killed run continues.

    With scenarios of kind time-effort in place of a study, compute time and effort against the
    weight of effort, and the front between the two.
    """
    with clean_exit():
        if any(is_study(case) for case in cases):
            if len(cases) > 1 or rho is not None:
                raise ScenarioError(
                    f"{' '.join(cases)}: a study comes without other cases and --rho; give it alone"
                )
            _study(cases[0], task, starts, seed, out, compile_cache, quiet)
            return
        if task is not None:
            raise ScenarioError(f"--task {task}: only studies have tasks; drop it")
        _weights(cases, rho, starts, seed, out, compile_cache, quiet)


def _study(
    case: str,
    task: str | None,
    starts: int | None,
    seed: int | None,
    out: Path | None,
    compile_cache: Path | None,
    quiet: bool,
) -> None:
    share = read_share(task)
    given = {"solver.starts": starts, "solver.seed": seed}
    study = load_study(case, {key: value for key, value in given.items() if value is not None})
    for note in study.notes:
        complain(f"Note: {study.origin}: {note}")
    folder = prepare_folder(out or Path("results") / study.name)
    path = folder / store_name(study.name, share)
    prepare_jax(compile_cache)
    try:
        with Reporter(samples_of(study, share), quiet) as report:
            found = sweep_study(study, path, share=share, report=report)
    except KeyboardInterrupt:
        complain(
            f"Interrupted; what is done stays in {path}, and the same command goes on from it."
        )
        raise typer.Exit(INTERRUPTED) from None
    if share != (0, 1):
        say(f"Task {task}: {found!r}; jaxatt merge joins the stores of all tasks")
    else:
        finish(repr(found), [path, *found.save(folder)], folder, quiet, found.table())
    end(found)


def end(found: Sweep) -> None:
    """Say how many samples do not reach or failed, and exit accordingly."""
    if not found.reached:
        missed, failed = found.missed, found.failed
        complain(f"{missed} samples do not reach their target, {failed} have no answer")
        raise typer.Exit(NOT_REACHED)


def _weights(
    cases: list[str],
    rho: str | None,
    starts: int | None,
    seed: int | None,
    out: Path | None,
    compile_cache: Path | None,
    quiet: bool,
) -> None:
    weights = WEIGHTS if rho is None else _read_weights(rho)
    loaded = [load(case) for case in cases]
    folder = prepare_folder(out or Path("results") / "-".join(case.name for case in loaded))
    prepare_jax(compile_cache)

    with Reporter(starts or loaded[0].solver.starts, quiet) as report:
        found = sweep_effort(loaded, weights, starts, seed, report)
    finish(repr(found), found.save(folder), folder, quiet, found.table())
    if not found.reached:
        complain("an optimum does not reach its target when flown")
        raise typer.Exit(NOT_REACHED)


def _read_weights(text: str) -> list[float]:
    """Read non-negative numbers separated by commas."""
    weights = numbers(text, "--rho")
    if not all(0.0 <= weight < float("inf") for weight in weights):
        raise typer.BadParameter(f"--rho {text}: a weight of effort must not be negative")
    return weights
