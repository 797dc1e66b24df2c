"""Command `jaxatt scenarios`."""

from __future__ import annotations

from typing import Annotated

import typer

from jaxatt.cli.common import clean_exit, say
from jaxatt.scenarios import text
from jaxatt.scenarios.bundled import KINDS, kind_of, titles
from jaxatt.scenarios.schema_line import schema_line

scenarios = typer.Typer(
    help="List the bundled scenarios, or print one as TOML.", add_completion=False
)


@scenarios.callback(invoke_without_command=True)
def list_scenarios(context: typer.Context) -> None:
    """List the bundled scenarios, one line each."""
    if context.invoked_subcommand is not None:
        return

    known = {name: title for kind in KINDS for name, title in titles(kind).items()}
    width = max(len(name) for name in known)
    with clean_exit():
        for name, title in known.items():
            say(f"{name:{width}}  {title}")


@scenarios.command("show")
def show_scenario(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A bundled scenario.")],
) -> None:
    """Print a bundled scenario as TOML, to be changed and solved."""
    with clean_exit():
        content = text(name)
        say(schema_line(kind_of(name) or ""), newline=False)
        say(content, newline=False)
