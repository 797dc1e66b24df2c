"""The commands, each loaded only when it is called: what one does not need costs it no time."""

from __future__ import annotations

import pkgutil
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

COMMANDS = {
    "solve": (
        "jaxatt.cli.solve:solve",
        "Find the sparsest or shortest manoeuvre, fly it again, write summary and figures.",
    ),
    "plan": (
        "jaxatt.cli.plan:plan",
        "Plan tasks that earn the most energy, fly the plan, write summary, archive and figures.",
    ),
    "pareto": (
        "jaxatt.cli.pareto:pareto",
        "Compute the Pareto front of a manoeuvre's energy against time or against its error.",
    ),
    "compare": (
        "jaxatt.cli.compare:compare",
        "Run every controller, law or transcription of a case beside its printed values.",
    ),
    "simulate": (
        "jaxatt.cli.simulate:simulate",
        "Fly a feedback law, once or in a campaign of thousands of runs.",
    ),
    "orbit": (
        "jaxatt.cli.orbit:orbit",
        "Show an orbit: elements, ground track, eclipses, the sun above its plane, magnetic field.",
    ),
    "new": (
        "jaxatt.cli.new:new",
        "Write a commented vehicle and scenario of one's own numbers.",
    ),
    "check": (
        "jaxatt.cli.check:check",
        "Say all that is wrong with TOML files, or what they describe.",
    ),
    "certify": (
        "jaxatt.cli.certify:certify",
        "Solve, then try every support with fewer active intervals, and all with as many.",
    ),
    "sparsity": (
        "jaxatt.cli.sparsity:sparsity",
        "Compute relative sparsity against intervals and torque limit, with a lower bound.",
    ),
    "sensitivities": (
        "jaxatt.cli.sensitivities:sensitivities",
        "Say how the answer of a scenario changes with the numbers of the scenario.",
    ),
    "design": (
        "jaxatt.cli.design:design",
        "Choose numbers of a scenario by descent: torque limits, mountings, sizes of wheels.",
    ),
    "sweep": (
        "jaxatt.cli.sweep:sweep",
        "Solve scenarios for many values of their numbers, sample by sample.",
    ),
    "map": (
        "jaxatt.cli.map:map_",
        "Map fewest intervals, least time or most energy over all turns from the initial attitude.",
    ),
    "merge": (
        "jaxatt.cli.merge:merge",
        "Join the stores of the tasks of a job array into one.",
    ),
    "show": (
        "jaxatt.cli.show:show",
        "Print and draw what the store of a sweep or of a map holds so far.",
    ),
    "export": (
        "jaxatt.cli.export:export",
        "Write the flown attitude, from EME2000 to body, as a file for other tools.",
    ),
    "conventions": (
        "jaxatt.cli.conventions:conventions",
        "Print one attitude as CCSDS, STK, Basilisk, SPICE and others write it.",
    ),
    "cache": (
        "jaxatt.cli.cache:cache",
        "Say what is kept of compiled programs, or remove it.",
    ),
    "schema": (
        "jaxatt.cli.schema:schema",
        "Print the JSON schema of a kind of TOML file, for editors.",
    ),
    "scenarios": (
        "jaxatt.cli.scenarios:scenarios",
        "List the bundled scenarios, or print one as TOML.",
    ),
}
"""Function or group of commands by its name, and the line that `jaxatt --help` has of it."""


TAKES = {
    "solve": "manoeuvre",
    "plan": "manoeuvre",
    "pareto": "manoeuvre",
    "certify": "manoeuvre",
    "sparsity": "manoeuvre",
    "sensitivities": "manoeuvre",
    "map": "manoeuvre",
    "simulate": "flight",
    "sweep": "study",
    "design": "design",
}
"""Kind of the file that a command takes first."""


class Commands(TyperGroup):
    """Commands by name, of which only the one that is called is loaded."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names, in the order of the help."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """What the help needs of a command; None for an unknown name."""
        if cmd_name not in COMMANDS:
            return None
        return TyperCommand(cmd_name, help=COMMANDS[cmd_name][1])

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """The command that is called, itself."""
        self.commands = {each: self.get_command(ctx, each) for each in COMMANDS}  # to be suggested
        name, command, rest = super().resolve_command(ctx, args)
        if command and name in TAKES and any(arg.endswith(".toml") for arg in rest):
            pkgutil.resolve_name("jaxatt.cli.early:refuse_early")(name, rest)
        return name, command and loaded(str(command.name)), rest


def loaded(name: str) -> Any:
    """Load a command."""
    found = pkgutil.resolve_name(COMMANDS[name][0])
    if not isinstance(found, typer.Typer):
        app = typer.Typer(add_completion=False)
        app.command(name)(found)
        found = app
    return typer.main.get_command(found)
