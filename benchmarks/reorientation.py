"""Starts of a reorientation in free time: the package beside IPOPT, on the same cores.

    python -m benchmarks.reorientation [--case mrp-k4-rk4] [--starts 1000] [--ipopt 300]

Both sides get the package's random feasible paths (section 4 of the source) and all cores: the
package one chunk of starts a core, IPOPT one process a core.  Building and compiling stand apart, a
first run warms up.  The sides take turns, straight after each other, so that a slow minute of the
machine slows both: in a turn the package solves all starts, IPOPT a share of those of `--ipopt`.
The ratio is the median over the turns.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import statistics
import tempfile
import time
from pathlib import Path

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from benchmarks.casadi_reorientation import minima  # noqa: E402
from benchmarks.ipopt_pool import flown_start, solve_together  # noqa: E402
from benchmarks.reorientation_numbers import Turn, case  # noqa: E402
from jaxatt import scenarios  # noqa: E402
from jaxatt.problems.time_optimal.phase import build_time_task  # noqa: E402
from jaxatt.problems.time_optimal.random_paths import random_paths  # noqa: E402
from jaxatt.problems.time_optimal.search import FreeTimeFound, search_free_time  # noqa: E402
from jaxatt.problems.time_optimal.task import ReorientationTask  # noqa: E402
from jaxatt.runtime.clock import compile_seconds  # noqa: E402


def package_side(task: ReorientationTask, starts: int, seed: int) -> tuple[float, FreeTimeFound]:
    """Solve, fly and judge all starts; the wall time [s] and what was found."""
    began = time.perf_counter()
    found = search_free_time(task, starts, seed)
    return time.perf_counter() - began, found


def in_turn(
    turn: Turn, rk4: bool, task: ReorientationTask, options: argparse.Namespace
) -> tuple[list[float], list[float]]:
    """Let both sides take turns, print the table, and return the times a start [s] of each."""
    before = compile_seconds()
    package_side(task, options.starts, options.seed)
    compiling = compile_seconds() - before
    paths = random_paths(task, options.starts, options.seed)
    torque = task.torques(paths.u[: options.ipopt])
    starts = [flown_start(turn, u, float(h)) for u, h in zip(torque, paths.step, strict=False)]
    ours, theirs, optima = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        solve_together(turn, rk4, starts[:2], Path(folder))
        building = time.perf_counter() - began
        for k in range(options.turns):
            wall, found = package_side(task, options.starts, options.seed)
            ours.append(wall / options.starts)
            share = starts[k :: options.turns]
            together = solve_together(turn, rk4, share, Path(folder))
            theirs.append(together.wall_s / len(share))
            optima += together.optima
    best = minima(optima, 1e-5)[0]
    passes = (np.median(found.iterations), statistics.median(o.iterations for o in optima))
    rows = (
        ("jaxatt", options.starts, compiling, ours, found.share, found.cost[found.best], passes[0]),
        ("IPOPT", len(starts), building, theirs, best[1] / len(starts), best[0], passes[1]),
    )
    print("| side | starts | compile [s] | a start [ms] | at the best | cost [s] | passes |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for side, count, build, times, share, cost, median in rows:
        print(
            f"| {side} | {count} | {build:.0f} | {1e3 * statistics.median(times):.2f} | "
            f"{100 * share:.1f} % | {cost:.6f} | {median:.0f} |"
        )
    return ours, theirs


def main() -> None:
    """Run both sides and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", default="mrp-k4-rk4")
    parser.add_argument("--starts", type=int, default=1000)
    parser.add_argument("--ipopt", type=int, default=300, help="starts that IPOPT solves")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--turns", type=int, default=5)
    options = parser.parse_args()
    options.ipopt = min(options.ipopt, options.starts)
    scenario = scenarios.load(options.case)
    task = build_time_task(scenario)
    turn = case(options.case.removesuffix("-rk4"))
    turn = dataclasses.replace(turn, intervals=task.intervals)
    rk4 = scenario.transcription.integration == "rk4"
    print(f"{options.case}, {len(os.sched_getaffinity(0))} cores\n")
    ours, theirs = in_turn(turn, rk4, task, options)
    ratios = [b / a for a, b in zip(ours, theirs, strict=True)]
    low, high = min(ratios), max(ratios)
    print(
        f"\nIPOPT takes {statistics.median(ratios):.1f} times as long a start "
        f"({low:.1f} to {high:.1f} in {options.turns} turns)."
    )


if __name__ == "__main__":
    main()
