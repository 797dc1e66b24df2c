"""How long the command line makes its users wait, in fresh processes.

`python -m benchmarks.waiting [--turns 5]` prints a table for `jaxatt solve hypso1-90-45-15` with an
empty compile cache and with a filled one, for its neighbours (another target, another inertia, more
intervals), and for commands that compute nothing: medians of wall time until the verdict is printed
and until the process ends, and of the processor time that it used.  All turns of one row come
straight after each other; trust ratios more than seconds on a machine that is not quiet.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.processes import run_to_the_end
from benchmarks.tables import grid

CASE = "hypso1-90-45-15"
INERTIA = [[0.08, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.22]]


def neighbours(home: Path) -> dict[str, Path]:
    """Scenarios beside the case: another target, another inertia, more intervals."""
    shown = subprocess.run(
        [sys.executable, "-m", "jaxatt", "scenarios", "show", CASE],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    changes = {
        "another target": ("[90.0, 45.0, 15.0]", "[60.0, 30.0, 20.0]"),
        "another inertia": ('use = "hypso1"', f'use = "hypso1"\ninertia_kgm2 = {INERTIA}'),
        "60 intervals": ("intervals = 50", "intervals = 60"),
    }
    made = {}
    for name, (old, new) in changes.items():
        if old not in shown:
            raise RuntimeError(f"{CASE} has no {old}")
        made[name] = home / f"{name.replace(' ', '-')}.toml"
        made[name].write_text(shown.replace(old, new, 1), encoding="utf-8")
    return made


def rows(turns: int) -> list[list[str]]:
    """The rows of the table."""
    home = Path(tempfile.mkdtemp())
    solve = ("solve", CASE, "--out", "out")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("JAX_", "XLA_"))}
    environment["XDG_CACHE_HOME"] = str(home / "cache")

    def row(
        name: str, arguments: Sequence[str], cold: bool = False, expected: int = 0
    ) -> list[str]:
        found = []
        for _ in range(turns):
            if cold:
                shutil.rmtree(home / "cache", ignore_errors=True)
            found.append(run_to_the_end(arguments, environment, home, "  status", expected))
        print(name, file=sys.stderr, flush=True)
        parts = ("printed_s", "wall_s", "processor_s")
        return [name, *(f"{statistics.median(getattr(e, p) for e in found):.2f}" for p in parts)]

    try:
        bad = home / "bad.toml"
        bad.write_text('title = "x"\nsystm = "spacecraft"\n', encoding="utf-8")
        return [
            row("empty cache", solve, cold=True),
            row("again", solve),
            row("again, --figures none", (*solve, "--figures", "none")),
            *(
                row(name, ("solve", str(file), "--out", "out"))
                for name, file in neighbours(home).items()
            ),
            row("jaxatt --help", ("--help",)),
            row("jaxatt scenarios", ("scenarios",)),
            row("a file with a fault", ("solve", str(bad)), expected=2),
        ]
    finally:
        shutil.rmtree(home, ignore_errors=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--turns", type=int, default=5, help="processes a row")
    heading = (f"jaxatt solve {CASE}", "to the verdict [s]", "to the end [s]", "processor [s]")
    print(grid(heading, rows(parser.parse_args().turns)))


if __name__ == "__main__":
    main()
