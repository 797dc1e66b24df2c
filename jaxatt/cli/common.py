"""Steps that all commands share: check input, show results, exit cleanly."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer
from rich.console import Console, RenderableType

from jaxatt import scenarios
from jaxatt.drawing.rendering import as_text
from jaxatt.report.result import Result
from jaxatt.runtime.files import OutputError, prepare_folder
from jaxatt.runtime.settings import configure
from jaxatt.scenarios import Scenario, ScenarioError

BAD_INPUT, NOT_REACHED, INTERRUPTED = 2, 3, 130


def prepare_jax(cache: Path | None = None) -> None:
    """Set JAX up for this process, before anything is computed."""

    configure(cache=cache)


def prepared(case: str, changes: dict[str, Any], out: Path | None) -> tuple[Scenario, Path]:
    """Load the scenario and prepare the output folder, so that bad input fails before the solve."""

    scenario = scenarios.load(case)
    given = {key: value for key, value in changes.items() if value is not None}
    if given:
        scenario = scenarios.replace(scenario, given)
    return scenario, prepare_folder(out or Path("results") / scenario.name)


def numbers(text: str, option: str) -> list[float]:
    """Read the numbers of an option that are separated by commas."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(f"{option} {text}: give numbers separated by commas") from None


def show(table: RenderableType) -> None:
    """Print a table, as plain text where the output is no terminal."""

    console = Console()
    if console.is_terminal:
        console.print(table)
    else:
        typer.echo(as_text(table))


def finish(line: str, files: list[Path], folder: Path, quiet: bool) -> None:
    """Print what was written, or with `quiet` the result in one line."""
    if quiet:
        typer.echo(f"{line}; {folder}")
        return
    plain = [str(file.relative_to(folder)) for file in files if file.suffix != ".png"]
    figures = sum(file.suffix == ".png" for file in files)
    typer.echo(f"Written to {folder}: {', '.join(plain)} and {figures} figures")


def shortfall(result: Result) -> str:
    """Sentences on what came closest to the target, and which constraint was in the way."""
    parts = []
    for number, phase in enumerate(result.phases, start=1):
        if phase.reached:
            continue
        where = f"Leg {number}: " if len(result.phases) > 1 else ""
        if phase.alternative is not None:
            parts.append(
                f"{where}The answer of lowest J does not reach the target; the best start that "
                "does is reported beside it."
            )
        else:
            parts.append(
                f"{where}No start reached the target; of the closest, {phase.failure_reason}."
            )
    return " ".join(parts)


@contextmanager
def clean_exit() -> Iterator[None]:
    """Turn bad input and interruption into a message and an exit code."""

    try:
        yield
    except (ScenarioError, OutputError) as error:
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(BAD_INPUT) from None
    except KeyboardInterrupt:
        typer.echo("Interrupted; nothing half-written was left behind.", err=True)
        raise typer.Exit(INTERRUPTED) from None
