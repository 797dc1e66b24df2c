"""`jaxatt solve` as a user meets it: a fresh process, without and with a cache of compilations."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Ended:
    """A process that has ended: wall time until it printed a line that was waited for and until its
    end, processor time [s], its largest memory."""

    printed_s: float
    wall_s: float
    processor_s: float
    memory_MiB: float


def run_to_the_end(
    arguments: Sequence[str],
    environment: Mapping[str, str],
    folder: Path | None = None,
    line: str = "",
    expected: int = 0,
) -> Ended:
    """Run `jaxatt` with arguments in a process of its own.

    folder : where it runs.  line : how the line begins that is waited for; the first, if it is
    empty.  Raises `RuntimeError` where it does not end with the status that is expected.
    """
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "jaxatt", *arguments],
        env={**environment, "PYTHONUNBUFFERED": "1"},
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdout is not None
    printed = None
    for text in process.stdout:
        if printed is None and text.startswith(line):
            printed = time.perf_counter() - began
    _, code, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(code)
    if process.returncode != expected:
        raise RuntimeError(f"jaxatt {' '.join(arguments)} ended with status {process.returncode}")
    processor = usage.ru_utime + usage.ru_stime
    return Ended(wall if printed is None else printed, wall, processor, usage.ru_maxrss / 1024.0)


@dataclass(frozen=True)
class Process:
    """One process: wall time, the compile and solve time it reports, its largest memory."""

    wall_s: float
    compile_s: float
    solve_s: float
    memory_MiB: float


def solve_process(case: str, cache: Path | None) -> Process:
    """Run `jaxatt solve CASE` in a process of its own.

    cache : folder of the persistent compilation cache, None for none.
    """
    environment = {k: v for k, v in os.environ.items() if k != "JAX_COMPILATION_CACHE_DIR"}
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["solve", case, "--quiet", "--out", folder]
        arguments += ["--no-cache"] if cache is None else ["--compile-cache", str(cache)]
        ended = run_to_the_end(arguments, environment)
        spent = json.loads((Path(folder) / "summary.json").read_text())["time_s"]
    return Process(ended.wall_s, spent["compile"], spent["solve"], ended.memory_MiB)


def cold_and_warm(case: str) -> dict[str, Process]:
    """Without a cache, and from a cache that an earlier process filled."""
    with tempfile.TemporaryDirectory() as cache:
        cold = solve_process(case, None)
        solve_process(case, Path(cache))
        return {"cold": cold, "cached": solve_process(case, Path(cache))}
