"""`jaxatt solve` as a user meets it: a fresh process, without and with a cache of compilations."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path


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
        command = [sys.executable, "-m", "jaxatt", "solve", case, "--quiet", "--out", folder]
        command += ["--no-cache"] if cache is None else ["--compile-cache", str(cache)]
        began = time.perf_counter()
        process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
        _, code, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - began
        process.returncode = code
        if code != 0:
            raise RuntimeError(f"jaxatt solve {case} ended with status {code}")
        spent = json.loads((Path(folder) / "summary.json").read_text())["time_s"]
    return Process(wall, spent["compile"], spent["solve"], usage.ru_maxrss / 1024.0)


def cold_and_warm(case: str) -> dict[str, Process]:
    """Without a cache, and from a cache that an earlier process filled."""
    with tempfile.TemporaryDirectory() as cache:
        cold = solve_process(case, None)
        solve_process(case, Path(cache))
        return {"cold": cold, "cached": solve_process(case, Path(cache))}
