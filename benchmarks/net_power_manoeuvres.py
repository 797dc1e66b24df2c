"""Useful starts a second of chapter 4's manoeuvre: the package beside IPOPT and FATROP.

    python -m benchmarks.net_power_manoeuvres [--starts 64] [--turns 5]

A start is useful where the fine flight of its torques ends within 0.01 deg and 1e-5 rad/s of the
target, with torques within their limits, and earns at least 573.45 J.  All sides begin from the
package's starts and have all cores: the package one chunk of starts a core, CasADi one process a
core, compiled to C.  The package's time holds its drawing of starts; building and compiling stand
apart, and the flights that judge count for no side.  The sides take turns, straight after each
other, and the ratios are medians over the turns.

CasADi stands here in two transcriptions: as the chapter prints it, with ten states and one
Runge-Kutta step an interval, and in the package's own, with seven states, a linear rate and one
exponential an interval.
"""

from __future__ import annotations

import argparse
import os
import statistics
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from benchmarks.attempts import Floats  # noqa: E402
from benchmarks.net_power_cases import manoeuvre  # noqa: E402
from benchmarks.net_power_pool import SIDES, solve_together  # noqa: E402
from jaxatt.problems.net_power.flight import fly  # noqa: E402
from jaxatt.problems.net_power.judge import judge_flight  # noqa: E402
from jaxatt.problems.net_power.manoeuvre import Manoeuvre  # noqa: E402
from jaxatt.problems.net_power.wheels.search import search_wheels  # noqa: E402
from jaxatt.problems.net_power.wheels.starts import draw_starts  # noqa: E402
from jaxatt.problems.net_power.wheels.task import wheels_task  # noqa: E402
from jaxatt.runtime.clock import compile_seconds  # noqa: E402

ENOUGH_J = 573.45


@dataclass(frozen=True)
class Turn:
    """One side in one turn: wall time [s], useful starts, best energy [J], passes (median)."""

    wall_s: float
    useful: int
    best_J: float
    passes: float

    @property
    def rate(self) -> float:
        """Useful starts a second."""
        return self.useful / self.wall_s


def useful(case: Manoeuvre, torque: Floats) -> tuple[int, float]:
    """How many answers (S, N, n) [N m] are useful, and the most energy [J] of those that reach."""
    flown = fly(case, torque)
    reached = judge_flight(case, flown).reached
    energy = np.where(reached, flown.energy.net_J, -np.inf)
    return int((energy >= ENOUGH_J).sum()), float(energy.max())


def package_turn(case: Manoeuvre, starts: int, seed: int) -> Turn:
    """Search from all starts."""
    began = time.perf_counter()
    (solved,) = search_wheels([case], starts, seed, None)
    wall = time.perf_counter() - began
    return Turn(wall, *useful(case, solved.torque), float(np.median(solved.iterations)))


def casadi_turn(
    case: Manoeuvre, side: str, starts: list[tuple[Floats, Floats]], folder: Path
) -> Turn:
    """Solve all starts with one of CasADi's sides."""
    together = solve_together("chapter-4", side, starts, folder)
    torque = np.stack([ended.torque for ended in together.ended])
    passes = statistics.median(ended.iterations for ended in together.ended)
    return Turn(together.wall_s, *useful(case, torque), float(passes))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--starts", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--folder", type=Path, help="keep compiled libraries here")
    options = parser.parse_args()
    case = manoeuvre("chapter-4")
    drawn = draw_starts(wheels_task(case), options.starts, options.seed)
    starts = [(drawn.u[i], drawn.x[i]) for i in range(options.starts)]
    before = compile_seconds()
    package_turn(case, options.starts, options.seed)
    compiling = compile_seconds() - before
    turns: dict[str, list[Turn]] = {"jaxatt": [], **{side: [] for side in SIDES}}
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        for side in SIDES:
            solve_together("chapter-4", side, starts[:2], folder)
        for _ in range(options.turns):
            turns["jaxatt"].append(package_turn(case, options.starts, options.seed))
            for side in SIDES:
                turns[side].append(casadi_turn(case, side, starts, folder))
    cores = len(os.sched_getaffinity(0))
    print(f"{options.starts} starts on {cores} cores; the package compiled for {compiling:.1f} s\n")
    print("| side | a start [ms] | passes | useful | best [J] | useful a second | the package's |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for side, its in turns.items():
        ratios = sorted(
            a.rate / max(b.rate, 1e-9) for a, b in zip(turns["jaxatt"], its, strict=True)
        )
        middle = statistics.median_low([turn.wall_s for turn in its])
        one = next(turn for turn in its if turn.wall_s == middle)
        times = f"{statistics.median(ratios):.1f} ({ratios[0]:.1f} to {ratios[-1]:.1f}) times"
        print(
            f"| {side} | {1e3 * middle / options.starts:.2f} | {one.passes:.0f} | "
            f"{one.useful} of {options.starts} | {one.best_J:.3f} | {one.rate:.1f} | {times} |"
        )


if __name__ == "__main__":
    main()
