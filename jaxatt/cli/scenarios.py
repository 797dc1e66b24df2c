"""`jaxatt scenarios`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import clean_exit, unknown

scenarios = typer.Typer(help="List the bundled scenarios, or print one as TOML.")


@scenarios.callback(invoke_without_command=True)
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


@scenarios.command("show")
def show_scenario(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A bundled scenario.")],
) -> None:
    """Print a bundled scenario as TOML, to be changed and solved."""
    with clean_exit():
        from jaxatt.scenarios import flight_names, flight_text, names, text

        if name == "hypso1-imaging":
            from jaxatt.imaging import imaging_text

            typer.echo(imaging_text(), nl=False)
            return
        if name in flight_names():
            typer.echo(flight_text(name), nl=False)
            return
        if name not in names():
            unknown(name, text)
        typer.echo(text(name), nl=False)
