"""Slews with CasADi and IPOPT in the strongest form that was found.

    python -m benchmarks.casadi_worker hypso1-90-45-15 32 0 out.npz

Seven-state model with conserved momentum, multiple shooting, exact derivatives, everything
expanded, mapped over the intervals and compiled; torques of three wheels as variables, so that
their limits are bounds; the printed relaxed complementarity (5.3) as two-sided rows, its target as
a constraint; informed guesses (`casadi_guesses`).  Options: the interior point starts at the guess
(bounds pushed by 1e-8) with a barrier to match (mu_init 1e-8), because the guess already says
where the torque is; with the defaults it needed about 120 iterations instead of 6.

Tried without gain: SPRAL instead of MUMPS (three to five times slower; the wheel has no other
solver for IPOPT), other orderings and scalings of MUMPS, adaptive mu, shooting over 2 or 5
intervals (fewer variables, the same time), no scaling, no multiplier estimate, -O3.
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
from benchmarks.cases import task_of

OPTIONS: dict[str, Any] = {
    "ipopt.tol": 1e-8,
    "ipopt.mu_init": 1e-8,
    "ipopt.bound_push": 1e-8,
    "ipopt.bound_frac": 1e-8,
    "ipopt.slack_bound_push": 1e-8,
    "ipopt.slack_bound_frac": 1e-8,
    "calc_lam_p": False,
    "no_nlp_grad": True,
}


def path_function(numbers: SlewNumbers) -> ca.Function:
    """Rows of one interval, (v, xi) -> xi tau in units of the torque, then the other wheels."""
    v, xi = ca.SX.sym("v", 3), ca.SX.sym("xi")
    torque = ca.mtimes(ca.DM(numbers.to_body / torque_unit(numbers)), v)
    return ca.Function("path", [v, xi], [ca.vertcat(xi * torque, ca.DM(numbers.other_wheels) @ v)])


def torque_unit(numbers: SlewNumbers) -> float:
    """[N m] of a unit of the complementarity rows."""
    return float(np.abs(numbers.to_body).max())


def program(numbers: SlewNumbers) -> dict[str, ca.MX]:
    """The program; its variables are v (3), xi and the next state (7), interval by interval."""
    n = numbers.intervals
    variables = ca.MX.sym("variables", 11 * n)
    stages = ca.reshape(variables, 11, n)
    controls, xi, states = stages[:3, :], stages[3, :], stages[4:, :]
    begin = ca.horzcat(ca.MX(ca.DM(start_state(numbers))), states[:, :-1])
    end = ca.SX.sym("end", 7)
    terminal = ca.Function("terminal", [end], [terminal_rows(numbers, end)])
    gaps = step_function(numbers).map(n)(begin, controls) - states
    path = path_function(numbers).map(n)(controls, xi)
    return {
        "x": variables,
        "f": ca.dot(ca.DM(numbers.weight).T, 1.0 - xi),
        "g": ca.veccat(gaps, path, terminal(states[:, -1])),
    }


def bounds(numbers: SlewNumbers) -> dict[str, Floats]:
    """Bounds of the variables and rows of `program`."""
    n, others = numbers.intervals, len(numbers.other_wheels)
    relaxation = np.full(3, numbers.epsilon / torque_unit(numbers))
    path = np.tile(np.r_[relaxation, np.ones(others)], n)
    return {
        "lbx": np.tile(np.r_[-np.ones(3), 0.0, np.full(7, -np.inf)], n),
        "ubx": np.tile(np.r_[np.ones(4), np.full(7, np.inf)], n),
        "lbg": np.r_[np.zeros(7 * n), -path, np.zeros(6)],
        "ubg": np.r_[np.zeros(7 * n), path, np.zeros(6)],
    }


def packed(guess: Guess) -> Floats:
    """A guess as variables of `program`."""
    return np.column_stack([guess.controls, guess.xi, guess.states]).ravel()


def prepare(case: str, seed: int, folder: Path) -> Solve:
    """Build everything and return the solver of single starts."""
    numbers = numbers_of(task_of(case))
    solver = compiled_solver("ipopt", program(numbers), OPTIONS, folder)
    limits = bounds(numbers)

    def solve(index: int) -> Attempt:
        answer = solver(x0=packed(pulse_guess(numbers, seed, index)), **limits)
        stages = np.asarray(answer["x"]).reshape(numbers.intervals, 11)
        stats = solver.stats()
        return Attempt(
            stages[:, :3] @ numbers.to_body.T, stats["return_status"], stats["iter_count"]
        )

    return solve
