"""The CasADi side of manoeuvres that earn energy on all cores: one process a core."""

from __future__ import annotations

import multiprocessing
import os
import time
from dataclasses import dataclass
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import jax
import numpy as np

from benchmarks.attempts import Floats
from benchmarks.casadi_net_power import Ended, Solver
from benchmarks.casadi_net_power_printed import PrintedSolver
from benchmarks.net_power_cases import manoeuvre
from jaxatt.problems.net_power.wheels.task import wheels_task

SIDES = {
    "IPOPT, printed": ("printed", "ipopt"),
    "FATROP, printed": ("printed", "fatrop"),
    "IPOPT": ("package", "ipopt"),
    "FATROP": ("package", "fatrop"),
}
"""Transcription and solver by the name that tables give the side.  The printed transcription has
ten states and a Runge-Kutta step, and is written for chapter 4 alone."""

_PATIENCE_S = 3600.0


@dataclass(frozen=True, eq=False)
class Together:
    """ended : one a start, in their order.  wall_s : from the first start to the last answer."""

    ended: list[Ended]
    wall_s: float


def solver(case: str, side: str, folder: Path) -> Solver | PrintedSolver:
    """Solver of a case, compiled into a folder of its own."""
    transcription, method = SIDES[side]
    own = folder / f"{case}-{transcription}-{method}"
    own.mkdir(parents=True, exist_ok=True)
    if transcription == "printed":
        if case != "chapter-4":
            raise ValueError(f"side = {side!r}: it is written for chapter-4 only, not {case}")
        return PrintedSolver(method, own)
    return Solver(wheels_task(manoeuvre(case)), method, own)


def solve_together(
    case: str, side: str, starts: list[tuple[Floats, Floats]], folder: Path
) -> Together:
    """Solve all starts, controls (N, b) and states (N + 1, s) each, on all cores.

    Building does not count, nor does a first solve in every process of several starts.
    """
    cores = sorted(os.sched_getaffinity(0))[: len(starts)]
    solver(case, side, folder)
    context = multiprocessing.get_context("spawn")
    barrier, answers = context.Barrier(len(cores)), context.Queue()
    workers = [
        context.Process(
            target=_work,
            args=(core, case, side, starts[k :: len(cores)], folder, barrier, answers),
        )
        for k, core in enumerate(cores)
    ]
    for worker in workers:
        worker.start()
    found = [answers.get(timeout=_PATIENCE_S) for _ in workers]
    for worker in workers:
        worker.join()
    by_core: dict[int, list[Ended]] = {core: ended for core, ended, _, _ in found}
    count = len(cores)
    ended = [by_core[cores[i % count]][i // count] for i in range(len(starts))]
    wall = max(last for _, _, _, last in found) - min(first for _, _, first, _ in found)
    return Together(ended, wall)


def _work(
    core: int,
    case: str,
    side: str,
    starts: list[tuple[Floats, Floats]],
    folder: Path,
    barrier: Barrier,
    answers: Any,
) -> None:
    os.sched_setaffinity(0, {core})
    jax.config.update("jax_enable_x64", True)
    solve = solver(case, side, folder)
    if len(starts) > 1:
        solve(*starts[0])
    barrier.wait(_PATIENCE_S)
    first = time.monotonic()
    ended = [solve(*(np.asarray(part) for part in start)) for start in starts]
    answers.put((core, ended, first, time.monotonic()))
