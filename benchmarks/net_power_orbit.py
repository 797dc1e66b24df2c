"""The longest harvest of an orbit from one start: the package beside IPOPT and FATROP.

    python -m benchmarks.net_power_orbit [--seed 0] [--repeats 3]

4380 s in 2190 intervals, through the Earth's shadow, with external torques, four wheels and
magnetorquers that manage their momentum.  All sides have the package's transcription and begin from
its start; CasADi is compiled to C and solves once, the package as often as asked, after a first
search that compiles.  What every side returns is flown finely.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

import jaxatt

jaxatt.configure()

import numpy as np  # noqa: E402

from benchmarks.attempts import Floats  # noqa: E402
from benchmarks.net_power_cases import manoeuvre  # noqa: E402
from benchmarks.net_power_pool import solve_together  # noqa: E402
from jaxatt.problems.net_power.flight import fly  # noqa: E402
from jaxatt.problems.net_power.judge import judge_flight  # noqa: E402
from jaxatt.problems.net_power.manoeuvre import Manoeuvre  # noqa: E402
from jaxatt.problems.net_power.wheels.search import search_wheels  # noqa: E402
from jaxatt.problems.net_power.wheels.starts import draw_starts  # noqa: E402
from jaxatt.problems.net_power.wheels.task import wheels_task  # noqa: E402
from jaxatt.runtime.clock import compile_seconds  # noqa: E402


def flown(case: Manoeuvre, torque: Floats) -> str:
    """What one answer (1, N, n) [N m] earns, and how far off its end it is."""
    flight = fly(case, torque)
    errors = judge_flight(case, flight).errors
    degrees = np.rad2deg(errors["attitude"][0])
    return f"{flight.energy.net_J[0]:.1f} | {degrees:.4f} | {errors['rate'][0]:.1e}"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--sides", nargs="*", default=["IPOPT", "FATROP"])
    parser.add_argument("--folder", type=Path, help="keep compiled libraries here")
    options = parser.parse_args()
    case = manoeuvre("task-7")
    before = compile_seconds()
    search_wheels([case], 1, options.seed, None)
    compiling = compile_seconds() - before
    walls = []
    for _ in range(options.repeats):
        began = time.perf_counter()
        (solved,) = search_wheels([case], 1, options.seed, None)
        walls.append(time.perf_counter() - began)
    ours = statistics.median(walls)
    print(f"the package compiled for {compiling:.1f} s\n")
    print("| side | time [s] | passes | net energy [J] | attitude [deg] | rate [rad/s] | times |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    passes = int(solved.iterations[0])
    print(f"| jaxatt | {ours:.2f} | {passes} | {flown(case, solved.torque)} | 1 |", flush=True)
    drawn = draw_starts(wheels_task(case), 1, options.seed)
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        for side in options.sides:
            together = solve_together("task-7", side, [(drawn.u[0], drawn.x[0])], folder)
            ended, wall = together.ended[0], together.wall_s
            judged = flown(case, ended.torque[None])
            print(
                f"| {side} ({ended.status}) | {wall:.2f} | {ended.iterations} | {judged} | "
                f"{wall / ours:.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
