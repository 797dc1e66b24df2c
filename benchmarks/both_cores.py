"""The CasADi side on all cores: one process a core, built apart, started together.

    python -m benchmarks.both_cores hypso1-90-45-15 64 0 [--method ipopt] [--processes 2]

Every process builds, solves one start to warm up and waits.  The clock runs from the common signal
to the end of the last process, and useful starts are counted by `usefulness`.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.casadi_worker import METHODS, Outcome, load
from benchmarks.cases import BEST_KNOWN, task_of
from benchmarks.usefulness import reaching, useful


@dataclass(frozen=True, eq=False)
class Together:
    """What all processes did.

    build_s : [s] wall time until the last process was ready, Python and the package included.
    wall_s : [s] from the common signal to the end of the last start.
    outcomes : one a process.
    """

    build_s: float
    wall_s: float
    outcomes: list[Outcome]


def run_together(
    case: str,
    starts: int,
    seed: int,
    method: str = "ipopt",
    processes: int | None = None,
    folder: Path | None = None,
) -> Together:
    """Split the starts among pinned processes and time them together.

    processes : by default one for every core that this process may use.
    folder : where compiled libraries are kept; by default every process compiles its own.

    Raises RuntimeError where a process fails.
    """
    cores = sorted(os.sched_getaffinity(0))
    count = min(processes or len(cores), len(cores), starts)
    with tempfile.TemporaryDirectory() as scratch:
        began = time.monotonic()
        files = [Path(scratch) / f"{k}.npz" for k in range(count)]
        workers = [
            subprocess.Popen(
                [
                    *(sys.executable, "-m", "benchmarks.casadi_worker"),
                    *(case, str(starts), str(seed), str(files[k])),
                    *("--method", method, "--core", str(cores[k]), "--wait"),
                    *("--share", str(k), str(count)),
                    *(() if folder is None else ("--folder", str(folder / str(k)))),
                ],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            for k in range(count)
        ]
        try:
            for worker in workers:
                _await_ready(worker)
            ready = time.monotonic()
            for worker in workers:
                assert worker.stdin is not None
                worker.stdin.write("go\n")
                worker.stdin.flush()
            for worker in workers:
                worker.communicate()
                if worker.returncode != 0:
                    raise RuntimeError(f"a process ended with exit code {worker.returncode}")
        finally:
            for worker in workers:
                if worker.poll() is None:
                    worker.kill()
        outcomes = [load(file) for file in files]
    last = max(outcome.ended_s for outcome in outcomes)
    return Together(ready - began, last - ready, outcomes)


def _await_ready(worker: subprocess.Popen[str]) -> None:
    """Read until the line "ready"; the solvers print their own banners before it."""
    assert worker.stdout is not None
    for line in worker.stdout:
        if line.strip() == "ready":
            return
    raise RuntimeError(f"a process ended with exit code {worker.wait()} before it was ready")


def report(case: str, together: Together) -> str:
    """One line of figures."""
    task, best = task_of(case), BEST_KNOWN[case]
    outcomes = together.outcomes
    good = sum(int(useful(task, o.controls, best).sum()) for o in outcomes)
    arrived = sum(int(reaching(task, o.controls).sum()) for o in outcomes)
    cpu = [seconds for o in outcomes for seconds in o.cpu_s]
    iterations = [count for o in outcomes for count in o.iterations]
    return (
        f"{case}: {len(outcomes)} processes, build {together.build_s:.1f} s, "
        f"run {together.wall_s:.3f} s for {len(cpu)} starts; "
        f"{arrived} reach, {good} useful; {len(cpu) / together.wall_s:.1f} starts/s, "
        f"{good / together.wall_s:.1f} useful starts/s; "
        f"CPU {_milliseconds(cpu)} ms a start, {statistics.median(iterations):g} iterations; "
        f"memory {max(o.memory_MiB for o in outcomes):.0f} MiB a process"
    )


def _milliseconds(seconds: Sequence[float]) -> str:
    return f"{1e3 * statistics.median(seconds):.1f}"


def main() -> None:
    """Run and print a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=tuple(BEST_KNOWN))
    parser.add_argument("starts", type=int)
    parser.add_argument("seed", type=int)
    parser.add_argument("--method", choices=tuple(METHODS), default="ipopt")
    parser.add_argument("--processes", type=int)
    parser.add_argument("--folder", type=Path, help="keep compiled libraries here")
    options = parser.parse_args()
    together = run_together(
        options.case,
        options.starts,
        options.seed,
        options.method,
        options.processes,
        options.folder,
    )
    print(report(options.case, together))


if __name__ == "__main__":
    main()
