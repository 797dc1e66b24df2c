"""The command line, one command a file.

Exit codes: 0 when every phase verifiably reached its target or every run flew to the end, 2 for bad
input or where output cannot be written, 3 when an answer does not reach or a run failed, 4 when
another process of the same computation is lost, 130 when interrupted.
"""

from __future__ import annotations

import typer

from jaxatt.cli.certify import certify
from jaxatt.cli.compare import compare
from jaxatt.cli.conventions import conventions
from jaxatt.cli.design import design
from jaxatt.cli.export import export
from jaxatt.cli.map import map_
from jaxatt.cli.merge import merge
from jaxatt.cli.orbit import orbit
from jaxatt.cli.pareto import pareto
from jaxatt.cli.plan import plan
from jaxatt.cli.scenarios import scenarios
from jaxatt.cli.sensitivities import sensitivities
from jaxatt.cli.show import show
from jaxatt.cli.simulate import simulate
from jaxatt.cli.solve import solve
from jaxatt.cli.sparsity import sparsity
from jaxatt.cli.sweep import sweep

app = typer.Typer(
    name="jaxatt",
    help="Spacecraft attitude manoeuvres that touch the actuators least.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (
    solve,
    plan,
    pareto,
    compare,
    simulate,
    orbit,
    certify,
    sparsity,
    sensitivities,
    design,
    sweep,
    merge,
    show,
    export,
    conventions,
):
    app.command()(command)
app.command("map")(map_)
app.add_typer(scenarios, name="scenarios")


def main() -> None:
    """Entry point of the `jaxatt` command."""
    app()
