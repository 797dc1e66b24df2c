"""Slews with CasADi's bundled FATROP: the program of `casadi_slew`, stage by stage.

python -m benchmarks.casadi_worker hypso1-90-45-15 32 0 out.npz --method fatrop

It applies: the program is already a chain of stages, and complementarity rows are inequalities of
their stage.  The Riccati recursion takes the place of MUMPS, which took most of IPOPT's time, so a
start costs less than half; iterations and answers are those of IPOPT.  As there, the barrier
starts small because the guess says where the torque is (13 iterations from the default).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.attempts import Attempt, Solve
from benchmarks.casadi_compiled import compiled_solver
from benchmarks.casadi_guesses import Guess, pulse_guess
from benchmarks.casadi_model import (
    Floats,
    SlewNumbers,
    numbers_of,
    start_state,
    step_function,
    terminal_rows,
)
from benchmarks.casadi_slew import path_function, torque_unit
from benchmarks.cases import task_of

FATROP: dict[str, Any] = {"print_level": 0, "tol": 1e-8, "mu_init": 1e-8, "max_iter": 1000}


def structure(numbers: SlewNumbers) -> dict[str, Any]:
    """Options that tell FATROP its stages: states, controls (v, xi), rows, equalities."""
    n, path = numbers.intervals, 3 + len(numbers.other_wheels)
    first = [True] * 14 + [False] * path
    later = [True] * 7 + [False] * path
    return {
        "structure_detection": "manual",
        "N": n,
        "nx": [7] * (n + 1),
        "nu": [4] * n + [0],
        "ng": [7 + path] + [path] * (n - 1) + [6],
        "equality": first + later * (n - 1) + [True] * 6,
    }


def program(numbers: SlewNumbers) -> dict[str, ca.MX]:
    """The program in FATROP's order: state (7), v (3), xi of every interval, the last state."""
    n = numbers.intervals
    variables = ca.MX.sym("variables", 11 * n + 7)
    stages = ca.reshape(variables[: 11 * n], 11, n)
    last = variables[11 * n :]
    states, controls, xi = stages[:7, :], stages[7:10, :], stages[10, :]
    end = ca.SX.sym("end", 7)
    terminal = ca.Function("terminal", [end], [terminal_rows(numbers, end)])
    following = ca.horzcat(states[:, 1:], last)
    # FATROP wants the next state with a plus sign.
    gaps = following - step_function(numbers).map(n)(states, controls)
    path = path_function(numbers).map(n)(controls, xi)
    start = states[:, 0] - ca.DM(start_state(numbers))
    rest = ca.vertcat(gaps[:, 1:], path[:, 1:])
    return {
        "x": variables,
        "f": ca.dot(ca.DM(numbers.weight).T, 1.0 - xi),
        "g": ca.veccat(gaps[:, 0], start, path[:, 0], rest, terminal(last)),
    }


def bounds(numbers: SlewNumbers) -> dict[str, Floats]:
    """Bounds of the variables and rows of `program`."""
    n, free = numbers.intervals, np.full(7, np.inf)
    path = np.r_[
        np.full(3, numbers.epsilon / torque_unit(numbers)), np.ones(len(numbers.other_wheels))
    ]
    upper = np.r_[np.zeros(14), path, np.tile(np.r_[np.zeros(7), path], n - 1), np.zeros(6)]
    return {
        "lbx": np.r_[np.tile(np.r_[-free, -np.ones(3), 0.0], n), -free],
        "ubx": np.r_[np.tile(np.r_[free, np.ones(4)], n), free],
        "lbg": -upper,
        "ubg": upper,
    }


def packed(numbers: SlewNumbers, guess: Guess) -> Floats:
    """A guess as variables of `program`."""
    states = np.concatenate([start_state(numbers)[None], guess.states])
    stages = np.column_stack([states[:-1], guess.controls, guess.xi])
    return np.concatenate([stages.ravel(), states[-1]])


def prepare(case: str, seed: int, folder: Path) -> Solve:
    """Build everything and return the solver of single starts."""
    numbers = numbers_of(task_of(case))
    options = {**structure(numbers), "fatrop": FATROP}
    solver = compiled_solver("fatrop", program(numbers), options, folder)
    limits = bounds(numbers)

    def solve(index: int) -> Attempt:
        answer = solver(x0=packed(numbers, pulse_guess(numbers, seed, index)), **limits)
        n = numbers.intervals
        stages = np.asarray(answer["x"]).ravel()[: 11 * n].reshape(n, 11)
        stats = solver.stats()
        return Attempt(
            stages[:, 7:10] @ numbers.to_body.T,
            stats["unified_return_status"],
            stats["iter_count"],
        )

    return solve
