"""Commands are loaded when they are called."""

import subprocess
import sys

import pytest
from typer.testing import CliRunner

from jaxatt.cli import app
from jaxatt.cli.commands import COMMANDS, loaded

HEAVY = ("jax", "matplotlib", "scipy", "xarray", "h5py", "zarr")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_has_the_first_line_of_each_command(name):
    assert loaded(name).help.splitlines()[0] == COMMANDS[name][1]


def test_units_are_no_markup_of_the_help():
    shown = CliRunner().invoke(app, ["new", "--help"]).output
    assert all(unit in shown for unit in ("[kg m^2]", "[rad/s]", "[deg]", "[N m]"))


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("--help",),
        ("--version",),
        ("scenarios",),
        ("scenarios", "show", "mrp-k4"),
        ("schema",),
        ("nosuch",),
    ],
)
def test_what_computes_nothing_loads_no_jax(arguments):
    code = (
        "import sys\nfrom jaxatt.cli import main\n"
        "try: main()\n"
        f"finally: print([name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, timeout=120
    )
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_drawing_waits_for_a_figure():
    code = (
        "import sys, jaxatt\n"
        "jaxatt.solve, jaxatt.minimize, jaxatt.scenarios.load('hypso1-netpower')\n"
        "print([name for name in ('matplotlib', 'xarray', 'h5py', 'zarr') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr
