"""Starts of a reorientation in free time: the package beside IPOPT, on the same cores.

    python -m benchmarks.reorientation [--case mrp-k4-rk4] [--starts 1000] [--ipopt 1000]

Both sides get the package's random feasible paths (section 4 of the source) and all cores: the
package one chunk of starts a core, IPOPT one process a core.  Building and compiling stand apart, a
first run warms up.  `--ipopt` says how many of the starts IPOPT solves; where it is not all of
them, its time is scaled up, and the table says so.
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
from jaxatt.clock import compile_seconds  # noqa: E402
from jaxatt.multistart.free_time import search_free_time  # noqa: E402
from jaxatt.multistart.random_paths import Paths, random_paths  # noqa: E402
from jaxatt.problems.reorientation_task import ReorientationTask  # noqa: E402
from jaxatt.time_legs import build_time_task  # noqa: E402


def package_side(task: ReorientationTask, starts: int, seed: int, repeats: int) -> float:
    """Solve, fly and judge all starts, print, and return the median wall time [s]."""
    before = compile_seconds()
    search_free_time(task, starts, seed)
    compiling = compile_seconds() - before
    walls = []
    for _ in range(repeats):
        began = time.perf_counter()
        found = search_free_time(task, starts, seed)
        walls.append(time.perf_counter() - began)
    wall = statistics.median(walls)
    print(
        f"| jaxatt | {starts} | {compiling:.0f} | {wall:.2f} | {1e3 * wall / starts:.2f} | "
        f"{100 * found.share:.1f} % | {found.cost[found.best]:.6f} | "
        f"{np.median(found.iterations):.0f} |",
        flush=True,
    )
    return wall


def ipopt_side(turn: Turn, rk4: bool, task: ReorientationTask, paths: Paths, count: int) -> float:
    """Solve the first `count` of the same paths, print, and return the wall time of all [s]."""
    torque = task.torques(paths.u[:count])
    starts = [flown_start(turn, u, float(h)) for u, h in zip(torque, paths.step, strict=False)]
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        together = solve_together(turn, rk4, starts, Path(folder))
        built = time.perf_counter() - began - together.wall_s
    found = minima(together.optima, 1e-5)
    share = found[0][1] / count
    median = statistics.median(optimum.iterations for optimum in together.optima)
    print(
        f"| IPOPT | {count} | {built:.0f} | {together.wall_s:.2f} | "
        f"{1e3 * together.wall_s / count:.2f} | {100 * share:.1f} % | {found[0][0]:.6f} | "
        f"{median:.0f} |"
    )
    return together.wall_s * len(paths.u) / count


def main() -> None:
    """Run both sides and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", default="mrp-k4-rk4")
    parser.add_argument("--starts", type=int, default=1000)
    parser.add_argument("--ipopt", type=int, help="starts that IPOPT solves; all by default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    scenario = scenarios.load(options.case)
    task = build_time_task(scenario)
    turn = case(options.case.removesuffix("-rk4"))
    turn = dataclasses.replace(turn, intervals=task.intervals)
    rk4 = scenario.transcription.integration == "rk4"
    count = options.starts if options.ipopt is None else min(options.ipopt, options.starts)
    print(f"{options.case}, {len(os.sched_getaffinity(0))} cores\n")
    print(
        "| side | starts | compile [s] | run [s] | a start [ms] | at the best | cost [s] | passes |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    ours = package_side(task, options.starts, options.seed, options.repeats)
    paths = random_paths(task, options.starts, options.seed)
    theirs = ipopt_side(turn, rk4, task, paths, count)
    scaled = "" if count == options.starts else f", scaled up from {count} of the starts"
    print(f"\nIPOPT takes {theirs / ours:.1f} times as long{scaled}.")


if __name__ == "__main__":
    main()
