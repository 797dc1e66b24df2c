"""Reorientation in free time with CasADi's bundled FATROP: the program of `casadi_reorientation`.

FATROP wants stages that are tied to their neighbours only.  So the step is a state of every stage
that nothing changes, free at the first node; it is kept as its logarithm, which needs no limit.
The Riccati recursion takes the place of MUMPS, and a start takes about half of IPOPT's time.

One start in thirty finds no end, whatever mu_init; it is given up after 100 iterations.

Tried without gain: mu_init from 1e-3 to 100 (two to four iterations more; from 1e-3 some starts
take a hundred), wider pushes off the bounds, a tolerance of 1e-8.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.casadi_compiled import compiled_solver
from benchmarks.casadi_reorientation import Optimum, step_function, timed
from benchmarks.reorientation_numbers import Floats, Start, Turn

FATROP: dict[str, Any] = {"print_level": 0, "tol": 1e-9, "mu_init": 0.02, "max_iter": 100}

_STATES = 7
"""sigma, the body rate and the logarithm of the step."""


def program(turn: Turn, rk4: bool) -> dict[str, ca.MX]:
    """Problem II in FATROP's order: state and torques of every interval, then the last state.

    The parameters are the target's sigma and rho, as in `casadi_reorientation.program`.
    """
    n, b = turn.intervals, turn.torques
    x, u, rho = ca.SX.sym("x", _STATES), ca.SX.sym("u", b), ca.SX.sym("rho")
    step = ca.exp(x[6])
    ahead = ca.vertcat(step_function(turn, rk4)(x[:6], u, step), x[6])
    stage = ca.Function("stage", [x, u, rho], [ahead, step * (1 + rho * ca.sumsqr(u))])
    variables = ca.MX.sym("variables", n * (_STATES + b) + _STATES)
    parameters = ca.MX.sym("p", 4)
    stages = ca.reshape(variables[: n * (_STATES + b)], _STATES + b, n)
    states, torques, last = stages[:_STATES, :], stages[_STATES:, :], variables[-_STATES:]
    after, cost = stage.map(n)(states, torques, ca.repmat(parameters[3], 1, n))
    # FATROP wants the next state with a plus sign.
    gaps = ca.horzcat(states[:, 1:], last) - after
    end = ca.vertcat(last[:3] - parameters[:3], last[3:6])
    rows = ca.veccat(gaps[:, 0], states[:6, 0], gaps[:, 1:], end)
    return {"x": variables, "p": parameters, "f": ca.sum2(cost), "g": rows}


def structure(turn: Turn) -> dict[str, Any]:
    """Options that tell FATROP its stages; all rows are equations."""
    n = turn.intervals
    return {
        "structure_detection": "manual",
        "N": n,
        "nx": [_STATES] * (n + 1),
        "nu": [turn.torques] * n + [0],
        "ng": [6] + [0] * (n - 1) + [6],
        "equality": [True] * (_STATES * n + 12),
    }


def packed(start: Start) -> Floats:
    """A start as variables of `program`."""
    states = np.column_stack([start.states, np.full(len(start.states), np.log(start.step))])
    return np.r_[np.column_stack([states[:-1], start.torques]).ravel(), states[-1]]


class FatropSolver:
    """Problem II of one turn, compiled; the target and rho may change between solves."""

    def __init__(
        self, turn: Turn, rk4: bool, folder: Path, options: dict[str, Any] | None = None
    ) -> None:
        """Build and compile into `folder`."""
        self.turn = turn
        settings = {**structure(turn), "fatrop": FATROP if options is None else options}
        self.function = compiled_solver("fatrop", program(turn, rk4), settings, folder)
        free = np.full(_STATES, np.inf)
        limits = np.tile(np.r_[free, np.full(turn.torques, turn.limit)], turn.intervals)
        bounds = np.r_[limits, free]
        self.limits = {"lbx": -bounds, "ubx": bounds, "lbg": 0.0, "ubg": 0.0}

    def __call__(self, start: Start, rho: float | None = None) -> Optimum:
        """Solve from a start."""
        n, b = self.turn.intervals, self.turn.torques
        x, cost, stats, spent = timed(self.function, self.limits, packed(start), self.turn, rho)
        torques = x[:-_STATES].reshape(n, _STATES + b)[:, _STATES:]
        status = "Solve_Succeeded" if stats["success"] else stats["unified_return_status"]
        return Optimum(torques, float(np.exp(x[-1])), cost, status, stats["iter_count"], spent)
