"""IPOPT or FATROP on the same starts on all cores: one process a core, each with its own share."""

from __future__ import annotations

import multiprocessing
import os
import time
from dataclasses import dataclass
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.casadi_reorientation import Optimum, Solver
from benchmarks.casadi_reorientation_fatrop import FatropSolver
from benchmarks.reorientation_numbers import Start, Turn

METHODS = {"IPOPT": Solver, "FATROP": FatropSolver}

_PATIENCE_S = 600.0


@dataclass(frozen=True, eq=False)
class Together:
    """optima : one a start, in their order.  wall_s : from the first start to the last answer."""

    optima: list[Optimum]
    wall_s: float


def solve_together(
    turn: Turn, rk4: bool, starts: list[Start], folder: Path, method: str = "IPOPT"
) -> Together:
    """Solve all starts on all cores; building and a first solve each do not count.

    folder : where the compiled program is kept; built here once, then used by every process.
    method : one of `METHODS`.
    """
    cores = sorted(os.sched_getaffinity(0))
    METHODS[method](turn, rk4, folder)
    context = multiprocessing.get_context("spawn")
    barrier, answers = context.Barrier(len(cores)), context.Queue()
    workers = [
        context.Process(
            target=_work,
            args=(core, turn, rk4, starts[k :: len(cores)], folder, method, barrier, answers),
        )
        for k, core in enumerate(cores)
    ]
    for worker in workers:
        worker.start()
    found = [answers.get(timeout=_PATIENCE_S) for _ in workers]
    for worker in workers:
        worker.join()
    by_core: dict[int, list[Optimum]] = {core: optima for core, optima, _, _ in found}
    optima = [by_core[cores[i % len(cores)]][i // len(cores)] for i in range(len(starts))]
    wall = max(end for _, _, _, end in found) - min(begin for _, _, begin, _ in found)
    return Together(optima, wall)


def _work(
    core: int,
    turn: Turn,
    rk4: bool,
    starts: list[Start],
    folder: Path,
    method: str,
    barrier: Barrier,
    answers: Any,
) -> None:
    os.sched_setaffinity(0, {core})
    solver = METHODS[method](turn, rk4, folder)
    if starts:
        solver(starts[0])
    barrier.wait(_PATIENCE_S)
    begin = time.monotonic()
    optima = [solver(start) for start in starts]
    answers.put((core, optima, begin, time.monotonic()))


def flown_start(turn: Turn, torques: np.ndarray, step: float) -> Start:
    """A start of torques (N, b) [N m] and a step [s] with the states of its forward Euler path."""
    states = [np.zeros(6)]
    for torque in torques:
        sigma, omega = states[-1][:3], states[-1][3:]
        straight = (1.0 - sigma @ sigma) * omega
        turning = 2.0 * np.cross(sigma, omega) + 2.0 * (sigma @ omega) * sigma
        slope = np.r_[0.25 * (straight + turning), turn.acceleration @ torque]
        states.append(states[-1] + step * slope)
    return Start(np.array(states), torques, step)
