"""Useful starts of a reorientation in free time: the package beside IPOPT and FATROP.

    python -m benchmarks.reorientation [--case mrp-k4-rk4] [--starts 1000] [--casadi 300]

All sides get the package's random feasible paths (section 4 of the source) and all cores: the
package one chunk of starts a core, CasADi one process a core.  Building and compiling stand apart,
a first run warms up.  The sides take turns, straight after each other, so that a slow minute of the
machine slows all: in a turn the package solves all starts, CasADi a share of those of `--casadi`.

A start is useful where the package's flight with fine steps reaches, and costs at most 1e-4 of
itself more than the best of all sides.  Ratios are of CPU time, which other work on the machine
touches least, and medians over the turns.  The package's time holds its paths and its flights with
their judgement; CasADi's is that of its solves alone.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import statistics
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from benchmarks.ipopt_pool import METHODS, flown_start, solve_together  # noqa: E402
from benchmarks.reorientation_numbers import Floats, Start, Turn, case  # noqa: E402
from jaxatt import scenarios  # noqa: E402
from jaxatt.problems.time_optimal.phase import build_time_task  # noqa: E402
from jaxatt.problems.time_optimal.random_paths import random_paths  # noqa: E402
from jaxatt.problems.time_optimal.search import search_free_time  # noqa: E402
from jaxatt.problems.time_optimal.task import ReorientationTask  # noqa: E402
from jaxatt.runtime.clock import compile_seconds  # noqa: E402

SAME = 1e-4
"""Relative difference of costs up to which two answers are one minimum."""


@dataclass(frozen=True)
class Side:
    """What a side did in one turn.

    wall_s, cpu_s : [s] for all starts of the turn.  cost : (S,) [s], infinite where the flight of
    an answer does not reach.  passes : median.
    """

    wall_s: float
    cpu_s: float
    cost: Floats
    passes: float

    def useful(self, best: float) -> float:
        """Share of the starts that are useful."""
        return float((self.cost <= best * (1.0 + SAME)).mean())


def package_side(task: ReorientationTask, starts: int, seed: int) -> Side:
    """Draw, solve, fly and judge all starts."""
    wall, cpu = time.perf_counter(), time.process_time()
    found = search_free_time(task, starts, seed)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    cost = np.where(found.reached, found.cost, np.inf)
    return Side(wall, cpu, cost, float(np.median(found.iterations)))


def casadi_side(
    turn: Turn, rk4: bool, task: ReorientationTask, starts: list[Start], folder: Path, method: str
) -> Side:
    """Solve starts with CasADi; the package flies and judges the answers, which does not count."""
    together = solve_together(turn, rk4, starts, folder, method)
    # Their answers overstep limits by a little more than the judgement of a flight allows.
    torque = np.clip(np.stack([o.torques for o in together.optima]), -turn.limit, turn.limit)
    step = np.array([o.step for o in together.optima])
    reached = task.judge(task.fly(torque, step), torque, step).reached
    cost = np.where(reached, task.cost(torque, step), np.inf)
    passes = statistics.median(o.iterations for o in together.optima)
    return Side(together.wall_s, sum(o.cpu_s for o in together.optima), cost, float(passes))


def in_turn(
    turn: Turn, rk4: bool, task: ReorientationTask, options: argparse.Namespace
) -> tuple[dict[str, list[Side]], dict[str, float]]:
    """Let all sides take turns: what each did in each turn, and what it took to build [s]."""
    before = compile_seconds()
    package_side(task, options.starts, options.seed)
    building = {"jaxatt": compile_seconds() - before}
    paths = random_paths(task, options.starts, options.seed)
    torque = task.torques(paths.u[: options.casadi])
    starts = [flown_start(turn, u, float(h)) for u, h in zip(torque, paths.step, strict=False)]
    sides: dict[str, list[Side]] = {"jaxatt": [], **{method: [] for method in METHODS}}
    with tempfile.TemporaryDirectory() as folder:
        for method in METHODS:
            began = time.perf_counter()
            casadi_side(turn, rk4, task, starts[:2], Path(folder), method)
            building[method] = time.perf_counter() - began
        for k in range(options.turns):
            sides["jaxatt"].append(package_side(task, options.starts, options.seed))
            share = starts[k :: options.turns]
            for method in METHODS:
                sides[method].append(casadi_side(turn, rk4, task, share, Path(folder), method))
    return sides, building


def table(sides: dict[str, list[Side]], building: dict[str, float]) -> str:
    """One row a side, with how many useful starts a CPU second the package finds for one of it."""
    best = min(side.cost.min() for turns in sides.values() for side in turns)
    rates = {
        name: [max(s.useful(best), 1e-9) * len(s.cost) / s.cpu_s for s in turns]
        for name, turns in sides.items()
    }
    lines = [
        "| side | compile [s] | a start [ms] | CPU a start [ms] | passes | useful | best cost [s] "
        "| useful a CPU second, the package's |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, turns in sides.items():
        ratios = [a / b for a, b in zip(rates["jaxatt"], rates[name], strict=True)]
        wall = statistics.median(1e3 * s.wall_s / len(s.cost) for s in turns)
        cpu = statistics.median(1e3 * s.cpu_s / len(s.cost) for s in turns)
        cost = np.concatenate([s.cost for s in turns])
        useful = float((cost <= best * (1.0 + SAME)).mean())
        passes = statistics.median(s.passes for s in turns)
        lines.append(
            f"| {name} | {building[name]:.0f} | {wall:.2f} | {cpu:.2f} | {passes:.0f} | "
            f"{100 * useful:.1f} % | {cost.min():.6f} | {statistics.median(ratios):.1f} "
            f"({min(ratios):.1f} to {max(ratios):.1f}) times |"
        )
    return "\n".join(lines)


def main() -> None:
    """Run both sides and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", default="mrp-k4-rk4")
    parser.add_argument("--starts", type=int, default=1000)
    parser.add_argument("--casadi", type=int, default=300, help="starts that CasADi solves")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--turns", type=int, default=5)
    options = parser.parse_args()
    options.casadi = min(options.casadi, options.starts)
    scenario = scenarios.load(options.case)
    task = build_time_task(scenario)
    turn = case(options.case.removesuffix("-rk4"))
    turn = dataclasses.replace(turn, intervals=task.intervals)
    rk4 = scenario.transcription.integration == "rk4"
    print(f"{options.case}, {len(os.sched_getaffinity(0))} cores\n")
    print(table(*in_turn(turn, rk4, task, options)))


if __name__ == "__main__":
    main()
