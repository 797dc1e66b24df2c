"""One process of the CasADi side: builds, warms up, waits for the signal, solves its starts.

    python -m benchmarks.casadi_worker CASE STARTS SEED OUT.npz [--method ipopt]

Pinned to one core with one thread.  With `--share K OF` it solves every OF-th start from K on;
with `--wait` it prints "ready" after the warm-up and solves once a line comes on standard input.
"""

from __future__ import annotations

import argparse
import importlib
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

# Before the libraries load; the last two are what SPRAL asks for, should it be chosen.
for _name, _value in (
    ("OMP_NUM_THREADS", "1"),
    ("OPENBLAS_NUM_THREADS", "1"),
    ("OMP_CANCELLATION", "TRUE"),
    ("OMP_PROC_BIND", "TRUE"),
):
    os.environ.setdefault(_name, _value)

import jax  # noqa: E402
import numpy as np  # noqa: E402

jax.config.update("jax_enable_x64", True)

from benchmarks.attempts import Floats, Solve  # noqa: E402
from benchmarks.cases import BEST_KNOWN  # noqa: E402

METHODS = {
    "ipopt": ("benchmarks.casadi_slew", "prepare"),
    "thesis-chain": ("benchmarks.casadi_thesis_chain", "prepare"),
    "thesis-chain-warm": ("benchmarks.casadi_thesis_chain", "prepare_warm"),
    "fatrop": ("benchmarks.casadi_fatrop", "prepare"),
    "thrusters": ("benchmarks.casadi_thrusters", "prepare"),
}
"""Module and function by method; only the one that is asked for is loaded."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one process did.

    build_s : [s] wall time from the case's name to a solver that has solved once.
    solve_s, cpu_s : (S,) [s] wall and processor time of every start.
    controls : (S, N, b), [N m] in body axes for a slew.
    status : the solver's word for every start.  iterations : (S,).
    began_s, ended_s : [s] on the machine's monotonic clock, which all processes share.
    memory_MiB : largest resident memory of the process.
    """

    build_s: float
    solve_s: list[float]
    cpu_s: list[float]
    controls: Floats
    status: list[str]
    iterations: list[int]
    began_s: float
    ended_s: float
    memory_MiB: float


def prepare(case: str, method: str, seed: int, folder: Path) -> Solve:
    """Solver of single starts of a case.  Raises ValueError where a method does not apply."""
    module, function = METHODS[method]
    if case == "double-integrator":
        if method != "ipopt":
            raise ValueError(f"{method} is not written for {case}")
        module = "benchmarks.casadi_double_integrator"
    solve: Solve = getattr(importlib.import_module(module), function)(case, seed, folder)
    return solve


def solve_many(
    case: str,
    starts: int,
    seed: int,
    method: str = "ipopt",
    share: tuple[int, int] = (0, 1),
    folder: Path | None = None,
    wait: Callable[[], None] | None = None,
) -> Outcome:
    """Build, warm up with a start that is not counted, and solve.

    share : (k, of), starts k, k + of, k + 2 of ... below `starts`.
    folder : where compiled libraries are kept; a new temporary one by default.
    wait : called between the warm-up and the first start.
    """
    with tempfile.TemporaryDirectory() as scratch:
        began = time.perf_counter()
        solve = prepare(case, method, seed, folder or Path(scratch))
        solve(starts)
        build_s = time.perf_counter() - began
        if wait is not None:
            wait()
        solve_s, cpu_s, attempts = [], [], []
        first = time.monotonic()
        for index in range(share[0], starts, share[1]):
            wall, cpu = time.perf_counter(), time.process_time()
            attempts.append(solve(index))
            solve_s.append(time.perf_counter() - wall)
            cpu_s.append(time.process_time() - cpu)
        last = time.monotonic()
    return Outcome(
        build_s=build_s,
        solve_s=solve_s,
        cpu_s=cpu_s,
        controls=np.array([attempt.controls for attempt in attempts]),
        status=[attempt.status for attempt in attempts],
        iterations=[attempt.iterations for attempt in attempts],
        began_s=first,
        ended_s=last,
        memory_MiB=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    )


def save(outcome: Outcome, path: Path) -> None:
    """Write an outcome as an .npz file."""
    np.savez(path, **{key: np.asarray(value) for key, value in vars(outcome).items()})


def load(path: Path) -> Outcome:
    """Read what `save` wrote."""
    with np.load(path) as file:
        values = {key: file[key] for key in file.files}
    controls = values.pop("controls")
    return Outcome(controls=controls, **{key: value.tolist() for key, value in values.items()})


def main() -> None:
    """Run as a process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", choices=tuple(BEST_KNOWN))
    parser.add_argument("starts", type=int)
    parser.add_argument("seed", type=int)
    parser.add_argument("out", type=Path)
    parser.add_argument("--method", choices=tuple(METHODS), default="ipopt")
    parser.add_argument("--core", type=int, help="core to be pinned to")
    parser.add_argument("--share", type=int, nargs=2, default=(0, 1), metavar=("K", "OF"))
    parser.add_argument("--folder", type=Path, help="keep compiled libraries here")
    parser.add_argument("--wait", action="store_true")
    options = parser.parse_args()
    allowed = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {allowed[0] if options.core is None else options.core})
    if options.folder is not None:
        options.folder.mkdir(parents=True, exist_ok=True)

    def signal() -> None:
        print("ready", flush=True)
        sys.stdin.readline()

    outcome = solve_many(
        options.case,
        options.starts,
        options.seed,
        options.method,
        tuple(options.share),
        options.folder,
        signal if options.wait else None,
    )
    save(outcome, options.out)


if __name__ == "__main__":
    main()
