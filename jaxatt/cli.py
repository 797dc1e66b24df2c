"""The command line: solve, simulate, compare, certify, list scenarios.

Exit codes: 0 when every leg verifiably reached its target or every run flew to the end, 2 for bad
input, 3 when an answer does not reach or a run failed, 130 when interrupted.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.console import RenderableType

    from jaxatt.report.result import Result
    from jaxatt.scenarios import Scenario

BAD_INPUT, NOT_REACHED, INTERRUPTED = 2, 3, 130


class Terminal(StrEnum):
    """How the end of the manoeuvre enters."""

    reach = "reach"
    penalty = "penalty"


class Objective(StrEnum):
    """What is made sparse."""

    l0 = "l0"
    moving_l0 = "moving-l0"
    l1 = "l1"


app = typer.Typer(
    name="jaxatt",
    help="Spacecraft attitude manoeuvres that touch the actuators least.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
bundled = typer.Typer(help="List the bundled scenarios, or print one as TOML.")
app.add_typer(bundled, name="scenarios")

Case = Annotated[
    str, typer.Argument(metavar="NAME_OR_FILE", help="A bundled scenario or a TOML file.")
]
Flight = Annotated[
    str, typer.Argument(metavar="NAME_OR_FILE", help="A bundled flight or a TOML file.")
]
Starts = Annotated[
    int | None, typer.Option(min=1, help="Number of starts.", show_default="the scenario's")
]
Seed = Annotated[
    int | None,
    typer.Option(min=0, help="Seed of the random starts.", show_default="the scenario's"),
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
        show_default="none",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", help="One line instead of progress and tables.")]


@app.command()
def solve(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    terminal: Annotated[
        Terminal | None,
        typer.Option(help="Reach the target, or minimise the printed cost.", show_default=False),
    ] = None,
    objective: Annotated[
        Objective | None, typer.Option(help="What is minimised.", show_default=False)
    ] = None,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Find the sparsest manoeuvre, fly it again, and write summary, archive and figures."""
    changes = {
        "solver.starts": starts,
        "solver.seed": seed,
        "objective.terminal": None if terminal is None else terminal.value,
        "objective.kind": None if objective is None else objective.value,
    }
    with _clean_exit():
        scenario, folder = _prepared(case, changes, out)
        _prepare_jax(compile_cache)
        from jaxatt.progress import Reporter
        from jaxatt.report.tables import resting_sentence, result_table
        from jaxatt.solving import solve as find

        with Reporter(scenario.solver.starts, quiet) as report:
            result = find(scenario, report=report)
        if not quiet:
            _show(result_table(result))
        files = result.save(folder)
        _finish(repr(result), files, folder, quiet)
        if not result.reached:
            # The table ends with this sentence already.
            sentence = resting_sentence(result) if quiet else ""
            typer.echo(f"{sentence} {_shortfall(result)}".strip(), err=True)
            raise typer.Exit(NOT_REACHED)


@app.command()
def compare(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Run every controller, or every law of a flight, with the printed values beside."""
    with _clean_exit():
        if case == "hypso1-imaging":
            _compare_imaging(out, quiet)
            return
        if _is_flight(case):
            _compare_flight(case, seed, out, compile_cache, quiet)
            return
        scenario, folder = _prepared(case, {"solver.starts": starts, "solver.seed": seed}, out)
        _prepare_jax(compile_cache)
        from jaxatt.comparison import compare as run
        from jaxatt.progress import Reporter

        with Reporter(scenario.solver.starts, quiet) as report:
            comparison = run(scenario, report=report)
        if not quiet:
            _show(comparison.table())
        files = comparison.save(folder)
        _finish(repr(comparison), files, folder, quiet)
        if not comparison.reached:
            for kind, result in comparison.results.items():
                if not result.reached:
                    typer.echo(f"{kind}: {_shortfall(result)}", err=True)
            raise typer.Exit(NOT_REACHED)


@app.command()
def simulate(
    case: Flight,
    law: Annotated[
        str | None,
        typer.Option(help="A law of the flight.", show_default="its first one"),
    ] = None,
    runs: Annotated[
        int | None,
        typer.Option(
            min=1, help="Runs, spread as the flight says.", show_default="the nominal one alone"
        ),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Seed of the runs.", show_default="the flight's")
    ] = None,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Fly a feedback law, once or in a campaign of thousands of runs."""
    with _clean_exit():
        from jaxatt.report.files import prepare_folder
        from jaxatt.scenarios.flight_catalog import load_flight

        _prepare_jax(compile_cache)
        flight = load_flight(case)
        folder = prepare_folder(out or Path("results") / flight.name)
        from jaxatt.progress import Reporter
        from jaxatt.report.flight_table import flight_table
        from jaxatt.simulating import simulate as run

        with Reporter(runs or 1, quiet) as report:
            result = run(flight, law, runs=runs, seed=seed, report=report)
        if not quiet:
            _show(flight_table(result))
        _finish(repr(result), result.save(folder), folder, quiet)
        if not result.sound.all():
            failed = {words: len(rows) for words, rows in result.failures.items()}
            typer.echo(
                "; ".join(
                    f"{number} of {result.runs}: {words}" for words, number in failed.items()
                ),
                err=True,
            )
            raise typer.Exit(NOT_REACHED)


@app.command()
def certify(
    case: Case,
    starts: Starts = None,
    seed: Seed = None,
    objective: Annotated[
        Objective | None, typer.Option(help="What is minimised.", show_default=False)
    ] = None,
    most: Annotated[
        int | None,
        typer.Option(
            min=1, help="Supports of one size that are tried at most.", show_default="50000"
        ),
    ] = None,
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Solve, then try every support with fewer active intervals, and all with as many."""
    changes = {
        "solver.starts": starts,
        "solver.seed": seed,
        "objective.kind": None if objective is None else objective.value,
    }
    with _clean_exit():
        scenario, folder = _prepared(case, changes, out)
        _prepare_jax(compile_cache)
        from jaxatt.certificate import MOST_SUPPORTS
        from jaxatt.certificate import certify as run
        from jaxatt.progress import Reporter

        with Reporter(scenario.solver.starts, quiet) as report:
            certificate = run(scenario, most=most or MOST_SUPPORTS, report=report)
        if not quiet:
            _show(certificate.table())
            for sentence in certificate.sentences():
                typer.echo(sentence)
        files = certificate.save(folder)
        _finish(" ".join(certificate.sentences()), files, folder, quiet)
        if not certificate.result.reached:
            raise typer.Exit(NOT_REACHED)


@app.command()
def sparsity(
    case: Case,
    starts: Annotated[int, typer.Option(min=1, help="Starts of every case.")] = 16,
    intervals: Annotated[
        str, typer.Option(help="Numbers of control intervals, separated by commas.")
    ] = "15,30,45,60,90,120",
    limits: Annotated[
        str, typer.Option(help="Multiples of the torque limit, separated by commas.")
    ] = "0.4,0.5,0.65,0.8,1,1.5,2",
    out: Out = None,
    compile_cache: Cache = None,
    quiet: Quiet = False,
) -> None:
    """Relative sparsity against intervals and torque limit, with the bound of impulse balance."""
    with _clean_exit():
        scenario, folder = _prepared(case, {}, out)
        counts, factors = _numbers("--intervals", intervals), _numbers("--limits", limits)
        if not all(count >= 2 and count == int(count) for count in counts):
            raise typer.BadParameter(f"{intervals}: give whole numbers of at least 2")
        _prepare_jax(compile_cache)
        from jaxatt.progress import Reporter
        from jaxatt.relative_sparsity import relative_sparsity
        from jaxatt.report.tables import sparsity_table

        with Reporter(starts, quiet) as report:
            study = relative_sparsity(
                scenario, [int(count) for count in counts], factors, starts, report
            )
        if not quiet:
            _show(sparsity_table(study.to_dict()))
        files = study.save(folder)
        _finish(repr(study), files, folder, quiet)


def _numbers(option: str, text: str) -> list[float]:
    """Positive numbers separated by commas."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(f"{text}: give numbers separated by commas") from None
    if not all(0.0 < number < float("inf") for number in numbers):
        raise typer.BadParameter(f"{option} {text}: every number must be greater than 0")
    return numbers


@bundled.callback(invoke_without_command=True)
def list_scenarios(context: typer.Context) -> None:
    """List the bundled scenarios with a line each."""
    if context.invoked_subcommand is not None:
        return
    from jaxatt.scenarios import flight_titles, titles

    known = {**titles(), **flight_titles()}
    known["hypso1-imaging"] = "Ground sampling distance along track: nadir pointing and slew"
    width = max(len(name) for name in known)
    for name, title in known.items():
        typer.echo(f"{name:{width}}  {title}")


@bundled.command("show")
def show_scenario(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A bundled scenario.")],
) -> None:
    """Print a bundled scenario as TOML, to be changed and solved."""
    with _clean_exit():
        from jaxatt.scenarios import flight_names, flight_text, names, text

        if name == "hypso1-imaging":
            from jaxatt.imaging import imaging_text

            typer.echo(imaging_text(), nl=False)
            return
        if name in flight_names():
            typer.echo(flight_text(name), nl=False)
            return
        if name not in names():
            _unknown(name, text)
        typer.echo(text(name), nl=False)


def main() -> None:
    """Entry point of the `jaxatt` command."""
    app()


def _prepare_jax(cache: Path | None = None) -> None:
    from jaxatt.runtime import configure

    configure(cache=cache)


def _prepared(case: str, changes: dict[str, Any], out: Path | None) -> tuple[Scenario, Path]:
    """The checked scenario and a folder that can be written: all that can be wrong beforehand."""
    from jaxatt import scenarios
    from jaxatt.report.files import prepare_folder

    if case not in scenarios.names() and not Path(case).is_file() and not case.endswith(".toml"):
        _unknown(case, scenarios.load)
    scenario = scenarios.load(case)
    given = {key: value for key, value in changes.items() if value is not None}
    if given:
        scenario = scenarios.replace(scenario, given)
    return scenario, prepare_folder(out or Path("results") / scenario.name)


def _is_flight(case: str) -> bool:
    """Whether a name or file is a flight, which has laws, rather than a manoeuvre to solve."""
    from jaxatt.scenarios import flight_names, names
    from jaxatt.scenarios.documents import read_file

    if case in (*names(), *flight_names()):
        return case not in names()
    return Path(case).is_file() and "laws" in read_file(Path(case))


def _compare_flight(
    case: str, seed: int | None, out: Path | None, cache: Path | None, quiet: bool
) -> None:
    from jaxatt.report.files import prepare_folder

    _prepare_jax(cache)
    from jaxatt.flight_comparison import compare_flight
    from jaxatt.progress import Reporter
    from jaxatt.scenarios import load_flight

    flight = load_flight(case)
    folder = prepare_folder(out or Path("results") / flight.name)
    with Reporter(len(flight.laws), quiet) as report:
        comparison = compare_flight(flight, seed, report)
    if not quiet:
        _show(comparison.table())
    _finish(repr(comparison), comparison.save(folder), folder, quiet)


def _compare_imaging(out: Path | None, quiet: bool) -> None:
    from jaxatt.report.files import prepare_folder

    folder = prepare_folder(out or Path("results") / "hypso1-imaging")
    _prepare_jax()
    from jaxatt.imaging import compare_imaging

    found = compare_imaging()
    if not quiet:
        _show(found.table())
    _finish(repr(found), found.save(folder), folder, quiet)


def _unknown(name: str, look_up: Any) -> None:
    """Raise the look-up's own error, which suggests a near name, and list what there is."""
    from jaxatt.scenarios import ScenarioError, names

    try:
        look_up(name)
    except ScenarioError as error:
        raise ScenarioError(f"{error}: {', '.join(names())}") from None


def _show(table: RenderableType) -> None:
    from rich.console import Console

    from jaxatt.report.rendering import as_text

    console = Console()
    if console.is_terminal:
        console.print(table)
    else:
        typer.echo(as_text(table))


def _finish(line: str, files: list[Path], folder: Path, quiet: bool) -> None:
    if quiet:
        typer.echo(f"{line}; {folder}")
        return
    plain = [str(file.relative_to(folder)) for file in files if file.suffix != ".png"]
    figures = sum(file.suffix == ".png" for file in files)
    typer.echo(f"Written to {folder}: {', '.join(plain)} and {figures} figures")


def _shortfall(result: Result) -> str:
    """What was closest, and what stood in its way."""
    parts = []
    for number, leg in enumerate(result.legs, start=1):
        if leg.reached:
            continue
        where = f"Leg {number}: " if len(result.legs) > 1 else ""
        if leg.alternative is not None:
            parts.append(
                f"{where}The answer of lowest J does not reach the target; the best start that "
                "does is reported beside it."
            )
        else:
            parts.append(f"{where}No start reached the target; of the closest, {leg.obstacle}.")
    return " ".join(parts)


@contextmanager
def _clean_exit() -> Iterator[None]:
    """Turn bad input and interruption into a message and an exit code."""
    from jaxatt.report.files import OutputError
    from jaxatt.scenarios import ScenarioError

    try:
        yield
    except (ScenarioError, OutputError) as error:
        typer.echo(f"Error: {error}", err=True)
        raise typer.Exit(BAD_INPUT) from None
    except KeyboardInterrupt:
        typer.echo("Interrupted; nothing half-written was left behind.", err=True)
        raise typer.Exit(INTERRUPTED) from None


if __name__ == "__main__":
    main()
