"""Useful starts a second by batch size on a GPU, beside IPOPT on all of the machine's cores.

    python -m benchmarks.gpu [--quick] [--limit 285] [--json FILE]

On a machine without a GPU the package's side runs on the CPU and the table says so; `--quick` takes
small batches.  A measurement begins only while the longest one so far would still fit, and when the
limit [s] is over the process prints what it has and ends.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib.util
import json
import os
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jaxatt

jaxatt.configure()

import jax  # noqa: E402

from benchmarks import accelerator_side  # noqa: E402
from benchmarks.__main__ import casadi_side, machine  # noqa: E402
from benchmarks.accelerator_side import SLEW, TURN, Rate  # noqa: E402
from benchmarks.casadi_reorientation import minima  # noqa: E402
from benchmarks.ipopt_pool import flown_start, solve_together  # noqa: E402
from benchmarks.reorientation_numbers import case  # noqa: E402
from jaxatt import scenarios  # noqa: E402
from jaxatt.problems.time_optimal.phase import build_time_task  # noqa: E402
from jaxatt.problems.time_optimal.random_paths import random_paths  # noqa: E402

_REPEATS = 3
_FIRST_S = 20.0
"""[s] What a measurement is taken to last before one has been made."""


def ipopt_slews(starts: int) -> Rate:
    """IPOPT from informed guesses of a slew, one process a core."""
    with tempfile.TemporaryDirectory() as folder:
        found = casadi_side(SLEW, "ipopt", starts, Path(folder))
    share = found["useful"] / starts
    return Rate(f"IPOPT, {SLEW}", "float64", starts, found["build_s"], found["run_s"], share)


def ipopt_turns(starts: int) -> Rate:
    """IPOPT from the package's own paths of a turn, one process a core."""
    task = build_time_task(scenarios.load(TURN))
    turn = dataclasses.replace(case(TURN.removesuffix("-rk4")), intervals=task.intervals)
    paths = random_paths(task, starts, 0)
    torque = task.torques(paths.u)
    guesses = [flown_start(turn, u, float(h)) for u, h in zip(torque, paths.step, strict=True)]
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        together = solve_together(turn, True, guesses, Path(folder))
        build = time.perf_counter() - began - together.wall_s
    share = minima(together.optima, 1e-4)[0][1] / starts
    return Rate(f"IPOPT, {TURN}", "float64", starts, build, together.wall_s, share)


def missing() -> dict[str, str]:
    """Why a side cannot run here, by its name."""
    lacks = {}
    if importlib.util.find_spec("casadi") is None:
        lacks["IPOPT"] = "CasADi is not installed (pip install 'jaxatt[benchmark]')"
    elif shutil.which("gcc") is None:
        lacks["IPOPT"] = "gcc is not installed, which compiles its functions"
    reasons = []
    if sys.version_info < (3, 12):
        reasons.append(f"it needs Python 3.12 or newer, this is {sys.version.split()[0]}")
    if jax.default_backend() != "gpu":
        reasons.append("it solves on an NVIDIA GPU with CUDA 13 only")
    if importlib.util.find_spec("jaxipm") is None:
        reasons.append("it is not installed")
    reasons.append("the turn is not yet written for it, for want of a machine to try it on")
    lacks["jaxipm"] = "; ".join(reasons)
    return lacks


def plan(quick: bool, lacks: dict[str, str]) -> list[tuple[str, Callable[[], Rate]]]:
    """What is measured, the most telling first."""
    side, sizes = accelerator_side, (64, 256) if quick else (256, 4096, 32768)
    cores = len(os.sched_getaffinity(0))
    steps: list[tuple[str, Callable[[], Rate]]] = []

    def add(what: str, run: Callable[[], Rate]) -> None:
        steps.append((what, run))

    for size in sizes:
        for single in (False, True):
            word = " in float32 first" if single else ""
            add(f"{size} roll-outs{word}", lambda n=size, s=single: side.rollouts(n, _REPEATS, s))
            add(f"{size} searches{word}", lambda n=size, s=single: side.searches(n, _REPEATS, s))
        if size <= 4096:
            add(f"{size} turns", lambda n=size: side.turns(n, _REPEATS))
        if size == sizes[0] and "IPOPT" not in lacks:
            add("slews by IPOPT", lambda: ipopt_slews(16 if quick else max(64, 4 * cores)))
            add("turns by IPOPT", lambda: ipopt_turns(8 if quick else max(32, 2 * cores)))
    return steps


def table(rates: list[Rate]) -> str:
    """The measurements in Markdown."""
    rows = [
        "| what | precision | batch | compile [s] | run [ms] | useful | useful a second |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    rows += [
        f"| {r.what} | {r.precision} | {r.batch} | {r.compile_s:.1f} | {1e3 * r.run_s:.1f} | "
        f"{100 * r.useful_share:.0f} % | {r.useful_per_second:.4g} |"
        for r in rates
    ]
    return "\n".join(rows)


def show(rates: list[Rate], skipped: list[str], file: Path | None) -> None:
    """Print machine, table and what was left out; write all of it if asked."""
    about: dict[str, Any] = machine() | {"backend": jax.default_backend()}
    about["devices"] = jax.device_count()
    print("; ".join(f"{key} {value}" for key, value in about.items()))
    if jax.default_backend() != "gpu":
        print("No GPU here: these are figures of the CPU.")
    print(f"\n{table(rates)}\n")
    for line in skipped:
        print(f"Not measured: {line}")
    sys.stdout.flush()
    if file is not None:
        content = {"machine": about, "rates": [dataclasses.asdict(r) for r in rates]}
        file.write_text(json.dumps(content | {"not_measured": skipped}, indent=2) + "\n")


def main() -> None:
    """Measure until all is done or the time is over."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small batches")
    parser.add_argument("--limit", type=float, default=285.0, help="seconds in all")
    parser.add_argument("--json", type=Path, help="write all figures there")
    options = parser.parse_args()
    began, lacks = time.monotonic(), missing()
    rates: list[Rate] = []
    skipped = [f"{name}: {reason}" for name, reason in lacks.items()]
    steps = plan(options.quick, lacks)

    def stop() -> None:
        left = ", ".join(what for what, _ in steps)
        show(rates, [*skipped, f"{left}: {options.limit:g} s were over"], options.json)
        os._exit(0)

    guard = threading.Timer(options.limit, stop)
    guard.daemon = True
    guard.start()
    longest = _FIRST_S
    while steps:
        what, run = steps[0]
        at = time.monotonic()
        if at - began + longest > options.limit:
            skipped.append(f"{what}: no time was left")
        else:
            try:
                rates.append(run())
                print(f"{what}: {rates[-1].useful_per_second:.4g} useful a second", flush=True)
            except (RuntimeError, MemoryError, ValueError) as error:
                skipped.append(f"{what}: {str(error).splitlines()[0]}")
            longest = max(longest, time.monotonic() - at)
        steps.pop(0)
    guard.cancel()
    show(rates, skipped, options.json)


if __name__ == "__main__":
    main()
