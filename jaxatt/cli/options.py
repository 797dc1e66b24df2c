"""Arguments and options that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from jaxatt.problems.reading.fields import ScenarioError
from jaxatt.problems.reading.tables.manoeuvre import MOST_SEED, MOST_STARTS
from jaxatt.problems.registry import kinds
from jaxatt.report.plots import Figures

MOST_TASKS = 100_000
FAILED_WHEELS = "vehicle.wheels.failed"


class Terminal(StrEnum):
    """Treatment of the target: as a constraint or as a penalty in the cost."""

    reach = "reach"
    penalty = "penalty"


_KINDS = kinds()


def _known_kind(value: str | None) -> str | None:
    if value is not None and value not in _KINDS:
        raise typer.BadParameter(f"{value!r} is not one of {', '.join(_KINDS)}.")
    return value


Case = Annotated[
    str, typer.Argument(metavar="NAME_OR_FILE", help="A bundled scenario or a TOML file.")
]
Flight = Annotated[
    str, typer.Argument(metavar="NAME_OR_FILE", help="A bundled flight or a TOML file.")
]
Starts = Annotated[
    int | None,
    typer.Option(min=1, max=MOST_STARTS, help="Number of starts.", show_default="the scenario's"),
]
Seed = Annotated[
    int | None,
    typer.Option(
        min=0, max=MOST_SEED, help="Seed of the random starts.", show_default="the scenario's"
    ),
]
FailedWheels = Annotated[
    list[str] | None,
    typer.Option(
        "--failed-wheel",
        metavar="NAME",
        help='A wheel that does not work, such as "wheel 2"; once for each.',
        show_default="the scenario's",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(help="Folder for the files, made if missing.", show_default="results/NAME"),
]
Cache = Annotated[
    Path | None,
    typer.Option(
        "--compile-cache",
        help="Folder that keeps compiled programs, so that the next process starts faster.",
        envvar="JAX_COMPILATION_CACHE_DIR",
        show_default="see jaxatt cache info",
    ),
]
NoCache = Annotated[bool, typer.Option("--no-cache", help="Keep no compiled programs.")]
Objective = Annotated[
    str | None,
    typer.Option(
        metavar="KIND",
        callback=_known_kind,
        help=f"Objective that is minimised: {', '.join(_KINDS)}.",
        show_default=False,
    ),
]
Task = Annotated[
    str | None,
    typer.Option(
        metavar="I/N",
        help="Solve the share of task I of N only, counted from 0, into a store of its own.",
        show_default="all",
    ),
]
Drawn = Annotated[Figures, typer.Option("--figures", help="Which figures are drawn.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="One line instead of progress and tables.")]
Coordinator = Annotated[
    str | None,
    typer.Option(
        metavar="HOST:PORT",
        help="Address of process 0, where several processes share the starts; auto: as SLURM or "
        "another scheduler says. All take the same command.",
        show_default="one process",
    ),
]
Processes = Annotated[
    int | None,
    typer.Option(min=1, help="How many processes there are.", show_default="the scheduler's"),
]
Process = Annotated[
    int | None,
    typer.Option(
        min=0,
        help="Which of them this is; process 0 writes and prints.",
        show_default="the scheduler's",
    ),
]
JoinTimeout = Annotated[
    float, typer.Option(min=1.0, help="Seconds within which all processes must have started.")
]


def read_share(text: str | None) -> tuple[int, int]:
    """Task i of n of a job array from "i/n"; (0, 1), all of it, by default."""
    if text is None:
        return (0, 1)
    first, _, count = text.partition("/")
    if first.isdecimal() and count.isdecimal() and int(first) < int(count) <= MOST_TASKS:
        return (int(first), int(count))
    raise ScenarioError(
        f"--task {text}: is no task of a job array; write 0/4 for the first of four, 3/4 for the "
        "last"
    )
