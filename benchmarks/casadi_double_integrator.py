"""The double integrator with CasADi and IPOPT in the strongest form that was found.

    python -m benchmarks.casadi_worker double-integrator 32 0 out.npz

Exact discretisation, multiple shooting, relaxed complementarity as two-sided rows, compiled.  The
guess is the least-effort control, found once while building, with random changes: for this system
the least effort and the fewest intervals have the same answer.  It is known: 1.837722 s of torque
with switches at 1.41886 s and 4.58114 s; on a grid of 0.05 s no fewer than 38 intervals can be
(`cases.BEST_KNOWN`).

Guesses that did worse: pushes of random length at random delays (221 iterations, 7 of 32 useful),
pushes of random length at both ends (288 iterations with these options, 4 of 16 useful).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from benchmarks.attempts import Attempt, Solve
from benchmarks.casadi_compiled import compiled_solver
from benchmarks.cases import task_of
from jaxatt.problems.toy.task import ToyTask

Floats = npt.NDArray[np.float64]

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

_CHANGE = 0.1
"""Standard deviation of the relative changes of the guess."""


def matrices(step: float) -> tuple[Floats, Floats]:
    """Exact discretisation x+ = A x + b u of x1' = x2, x2' = u over `step` [s]: (2, 2), (2,)."""
    return np.array([[1.0, step], [0.0, 1.0]]), np.array([step**2 / 2.0, step])


def program(task: ToyTask) -> dict[str, ca.MX]:
    """The program; its variables are u, xi and the next state (2), interval by interval."""
    n = task.intervals
    a, b = matrices(task.step)
    variables = ca.MX.sym("variables", 4 * n)
    stages = ca.reshape(variables, 4, n)
    u, xi, states = stages[0, :], stages[1, :], stages[2:, :]
    start = ca.MX(ca.DM(np.asarray(task.parameters.start)))
    begin = ca.horzcat(start, states[:, :-1])
    gaps = ca.DM(a) @ begin + ca.DM(b) @ (u * task.limit) - states
    return {
        "x": variables,
        "f": ca.sum2(1.0 - xi),
        "g": ca.veccat(gaps, u * xi, states[:, -1]),
    }


def bounds(task: ToyTask) -> dict[str, Floats]:
    """Bounds of the variables and rows of `program`."""
    n, target = task.intervals, np.asarray(task.parameters.target)
    relaxation = np.full(n, task.goal.epsilon / task.limit)
    infinite = np.full(2, np.inf)
    return {
        "lbx": np.tile(np.r_[-1.0, 0.0, -infinite], n),
        "ubx": np.tile(np.r_[1.0, 1.0, infinite], n),
        "lbg": np.r_[np.zeros(2 * n), -relaxation, target],
        "ubg": np.r_[np.zeros(2 * n), relaxation, target],
    }


def least_effort(task: ToyTask) -> Floats:
    """Control of least effort in units of the limit, (N,): a linear program."""
    n = task.intervals
    a, b = matrices(task.step)
    variables = ca.MX.sym("variables", 4 * n)
    stages = ca.reshape(variables, 4, n)
    u, states = stages[0, :] - stages[1, :], stages[2:, :]
    start = ca.MX(ca.DM(np.asarray(task.parameters.start)))
    gaps = ca.DM(a) @ ca.horzcat(start, states[:, :-1]) + ca.DM(b) @ (u * task.limit) - states
    rows = ca.veccat(gaps, states[:, -1] - ca.DM(np.asarray(task.parameters.target)))
    effort = ca.sum2(stages[0, :] + stages[1, :])
    solver = ca.nlpsol(
        "effort",
        "ipopt",
        {"x": variables, "f": effort, "g": rows},
        {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False},
    )
    infinite = np.full(2, np.inf)
    lower, upper = np.r_[0.0, 0.0, -infinite], np.r_[1.0, 1.0, infinite]
    answer = solver(x0=0.0, lbx=np.tile(lower, n), ubx=np.tile(upper, n), lbg=0.0, ubg=0.0)
    parts = np.asarray(answer["x"]).reshape(n, 4)
    return parts[:, 0] - parts[:, 1]


def guess(task: ToyTask, effort: Floats, seed: int, index: int) -> Floats:
    """The least-effort control (N,) with random relative changes, as variables of `program`."""
    draw = np.random.default_rng([seed, index])
    u = np.clip(effort * (1.0 + _CHANGE * draw.normal(size=task.intervals)), -1.0, 1.0)
    u = np.where(np.abs(u) < task.threshold, 0.0, u)
    a, b = matrices(task.step)
    states, x = [], np.asarray(task.parameters.start)
    for value in u:
        x = a @ x + b * value * task.limit
        states.append(x)
    return np.column_stack([u, u == 0.0, states]).ravel()


def prepare(case: str, seed: int, folder: Path) -> Solve:
    """Build everything and return the solver of single starts.

    Raises ValueError for another case than the double integrator.
    """
    task = task_of(case)
    if not isinstance(task, ToyTask) or task.name != "double-integrator":
        raise ValueError(f"{case} is not the double integrator")
    solver = compiled_solver("ipopt", program(task), OPTIONS, folder)
    limits, effort = bounds(task), least_effort(task)

    def solve(index: int) -> Attempt:
        answer = solver(x0=guess(task, effort, seed, index), **limits)
        stages = np.asarray(answer["x"]).reshape(task.intervals, 4)
        stats = solver.stats()
        return Attempt(stages[:, :1] * task.limit, stats["return_status"], stats["iter_count"])

    return solve
