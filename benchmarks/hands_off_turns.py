"""Useful starts of a hands-off slew in a CPU second: the package beside IPOPT and FATROP.

    python -m benchmarks.hands_off_turns [--case hypso1-90-45-15] [--batches 64 1024] [--turns 5]

All sides take turns, straight after each other, and get all cores: the package one chunk of starts
a core, CasADi one process a core.  Compiling and building stand apart, a first run warms up.  What
counts is CPU time, which other work on the machine touches least; *useful* is what it is in
`benchmarks.usefulness`.  Printed are medians over the turns, and the least and largest.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from benchmarks.both_cores import run_together  # noqa: E402
from benchmarks.cases import BEST_KNOWN, task_of  # noqa: E402
from benchmarks.jaxatt_side import deciding  # noqa: E402
from benchmarks.usefulness import useful  # noqa: E402

PEERS = ("ipopt", "fatrop")


@dataclass(frozen=True)
class Side:
    """What a side did in a turn.  cpu_ms : [ms] a start.  share : of useful starts."""

    cpu_ms: float
    share: float

    @property
    def rate(self) -> float:
        """Useful starts a CPU second."""
        return 1e3 * self.share / self.cpu_ms


def package_side(case: str, batch: int, repeats: int) -> Side:
    """Search from random starts, their drawing included; the median of several calls."""
    task, run = task_of(case), deciding(case, batch)
    run(0)
    seconds, shares = [], []
    for index in range(repeats):
        began = time.process_time()
        controls = run(index)
        seconds.append(time.process_time() - began)
        shares.append(useful(task, controls, BEST_KNOWN[case]).mean())
    return Side(1e3 * statistics.median(seconds) / batch, float(np.mean(shares)))


def casadi_side(case: str, method: str, starts: int, folder: Path) -> Side:
    """Solve from informed guesses, one process a core."""
    together = run_together(case, starts, 0, method, folder=folder / method)
    task, outcomes = task_of(case), together.outcomes
    good = sum(int(useful(task, o.controls, BEST_KNOWN[case]).sum()) for o in outcomes)
    seconds = [cpu for outcome in outcomes for cpu in outcome.cpu_s]
    return Side(1e3 * statistics.mean(seconds), good / len(seconds))


def table(sides: dict[str, list[Side]]) -> str:
    """One row a side, and how many times as many useful starts a CPU second the package finds."""
    heads = ["side", "CPU a start [ms]", "useful", "useful a CPU second"]
    heads += [f"times {peer}'s" for peer in PEERS]
    lines = [" | ".join(["", *heads, ""]).strip(), "| --- " * len(heads) + "|"]
    for name, turns in sides.items():
        cells = [
            name,
            f"{statistics.median(x.cpu_ms for x in turns):.3f}",
            f"{100 * statistics.mean(x.share for x in turns):.1f} %",
            f"{statistics.median(x.rate for x in turns):.0f}",
        ]
        for peer in PEERS:
            ratios = [a.rate / b.rate for a, b in zip(turns, sides[peer], strict=True)]
            middle = statistics.median(ratios)
            cells.append(f"{middle:.1f} ({min(ratios):.1f} to {max(ratios):.1f})")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Let all sides take turns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", default="hypso1-90-45-15")
    parser.add_argument("--batches", type=int, nargs="+", default=[64, 256, 1024])
    parser.add_argument(
        "--starts", type=int, default=64, help="starts that CasADi solves in a turn"
    )
    parser.add_argument("--repeats", type=int, default=9, help="calls of the package in a turn")
    parser.add_argument("--turns", type=int, default=5)
    options = parser.parse_args()
    sides: dict[str, list[Side]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(options.turns):
            for batch in options.batches:
                found = package_side(options.case, batch, options.repeats)
                sides.setdefault(f"jaxatt, {batch} starts", []).append(found)
            for peer in PEERS:
                found = casadi_side(options.case, peer, options.starts, Path(folder))
                sides.setdefault(peer, []).append(found)
    print(table(sides))


if __name__ == "__main__":
    main()
