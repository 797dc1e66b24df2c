"""Steps that all commands share: check input, show results, exit cleanly."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import typer
from rich.console import Console, RenderableType

from jaxatt import scenarios
from jaxatt.drawing.rendering import as_text
from jaxatt.problems.reading.fields import ScenarioError, ScenarioErrors
from jaxatt.problems.reading.lines import located
from jaxatt.runtime.compile_cache import machine_cache, make_private, trim, user_cache
from jaxatt.runtime.files import OutputError, prepare_folder
from jaxatt.runtime.joining import JoinError, Joining, LostProcessError, leave, several, writes
from jaxatt.runtime.source import source_digest

if TYPE_CHECKING:
    from jaxatt.report.plots import Figures
    from jaxatt.report.result import Result
    from jaxatt.scenarios import Scenario

BAD_INPUT, NOT_REACHED, LOST, INTERRUPTED = 2, 3, 4, 130

_ALONE = Joining()


@contextmanager
def computing(cache: Path | None = None, no_cache: bool = False) -> Iterator[None]:
    """Set JAX up for what is computed inside, and leave as `clean_exit` does.

    cache : folder that keeps compiled programs, the user's own by default.
    """
    from jaxatt.runtime.settings import configure  # commands that compute nothing load no JAX

    with clean_exit():
        folder = None if no_cache else cache or machine_cache()
        trouble = "" if folder is None else make_private(folder)
        if trouble:
            complain(f"Note: {trouble}")
        configure(cache=None if trouble else folder, keep=not (no_cache or trouble))
        try:
            yield
        finally:
            if folder is not None and cache is None and not trouble:
                trim(user_cache())


def prepared(
    case: str, changes: dict[str, Any], out: Path | None, joining: Joining = _ALONE
) -> tuple[Scenario, Path]:
    """Load the scenario and prepare the output folder, so that bad input fails before the solve.

    joining : other processes, which are waited for; only process 0 needs the folder.
    """
    from jaxatt.runtime.processes import agree

    joining.join()  # first: reading a scenario may compute, after which nobody can join
    scenario = scenarios.load(case)
    given = {key: value for key, value in changes.items() if value is not None}
    if given:
        scenario = scenarios.replace(scenario, given)
    same = repr((scenario.document, source_digest())).encode()
    agree(np.frombuffer(same, np.uint8), "another scenario or other code")
    folder = out or Path("results") / scenario.name
    return scenario, prepare_folder(folder) if writes() else folder


def numbers(text: str, option: str) -> list[float]:
    """Read the numbers of an option that are separated by commas."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(f"{option} {text}: give numbers separated by commas") from None


def say(text: str, *, newline: bool = True) -> None:
    """Print on standard output; a reader that has gone has read enough.

    Raises `OutputError` where it cannot be written for another reason, such as a full disk.
    """
    with _standard_output():
        typer.echo(text, nl=newline)


def complain(text: str) -> None:
    """Print on the standard error stream, if anybody listens."""
    with suppress(OSError):
        typer.echo(text, err=True)


def finish(
    line: str,
    write: Callable[[], list[Path]],
    folder: Path,
    quiet: bool,
    table: RenderableType,
    sentences: Iterable[str] = (),
) -> None:
    """Print a result, the table or `line` if quiet, then write its files and say where they are.

    Nobody waits for files and figures to read the result, and they are written where nothing can
    be printed, too.
    """
    from jaxatt.records.wording import plural

    unprinted = None
    try:
        if quiet:
            say(f"{line}; {folder}")
        else:
            _show(table)
            for sentence in sentences:
                say(sentence)
    except OutputError as error:
        unprinted = error
    files = write()
    plain = [str(file.relative_to(folder)) for file in files if file.suffix != ".png"]
    figures = plural(len(files) - len(plain), "figure")
    try:
        if unprinted is not None:
            raise unprinted
        if not quiet:
            say(f"Written to {folder}: {' and '.join(filter(None, [', '.join(plain), figures]))}")
    except OutputError as error:
        raise OutputError(f"{error}; all files are in {folder}") from error


def finish_result(result: Result, folder: Path, figures: Figures, quiet: bool) -> None:
    """Print a result, write and draw it."""
    from jaxatt.report.tables import result_table

    finish(repr(result), lambda: result.save(folder, figures), folder, quiet, result_table(result))


def _show(table: RenderableType) -> None:
    """Print a table, as plain text where the output is no terminal."""
    console = Console()
    if not console.is_terminal:
        say(as_text(table))
        return
    with _standard_output():
        console.print(table)


@contextmanager
def _standard_output() -> Iterator[None]:
    try:
        yield
    except BrokenPipeError:
        _discard_the_rest()
    except OSError as error:
        _discard_the_rest()
        raise OutputError(f"standard output: cannot be written ({error.strerror})") from error


def _discard_the_rest() -> None:
    """Send what is still to be printed nowhere, or the interpreter fails on it at its end."""
    with suppress(OSError):  # streams that belong to no file
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


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


def refused(error: ScenarioError) -> None:
    """Print all errors of an input, with their lines where those are known."""
    for each in error.errors if isinstance(error, ScenarioErrors) else (error,):
        complain(f"Error: {located(each)}")


@contextmanager
def clean_exit() -> Iterator[None]:
    """Turn bad input, lost processes and interruption into a message and an exit code."""

    try:
        yield
    except ScenarioError as error:
        refused(error)
        _end(BAD_INPUT)
    except (OutputError, JoinError) as error:
        complain(f"Error: {error}")
        _end(BAD_INPUT)
    except LostProcessError as error:
        complain(f"Error: {error}; nothing half-written was left behind")
        _end(LOST)
    except KeyboardInterrupt:
        complain("Interrupted; nothing half-written was left behind.")
        _end(INTERRUPTED)
    except typer.Exit:
        raise
    except Exception:
        if several():
            traceback.print_exc()
            _end(1)
        raise


def _end(code: int) -> NoReturn:
    """End with an exit code, so that other processes learn of it at once."""
    if several():
        leave(code)
    raise typer.Exit(code) from None
