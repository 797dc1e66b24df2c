"""Slews with one-sided thrusters, with CasADi and IPOPT: relaxed complementarity, target reached.

    python -m benchmarks.casadi_worker eseo-1 8 0 out.npz --method thrusters

Multiple shooting with one RK4 step an interval, exact derivatives, everything expanded, mapped
over the intervals, compiled.  The complementarity (8f) of Kristiansen and Gravdahl (2023) joins
all thrusters, the target is a constraint.  Guesses are bang-bang: full torque about the turn's axis
in a first and a last burst of random length, flown, with the xi that belongs to them.

Options: as in `casadi_slew`, starting at the guess.  Larger pushes and barriers (1e-6, 1e-4, 1e-2)
took two to three times longer on the first four starts and failed on one to three of them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.attempts import Attempt, Floats, Solve
from benchmarks.casadi_compiled import compiled_solver
from benchmarks.cases import task_of
from jaxatt.problems.hands_off.slew.task import SlewTask

OPTIONS: dict[str, Any] = {
    "ipopt.tol": 1e-8,
    "ipopt.mu_init": 1e-8,
    "ipopt.bound_push": 1e-8,
    "ipopt.bound_frac": 1e-8,
    "ipopt.slack_bound_push": 1e-8,
    "ipopt.slack_bound_frac": 1e-8,
    "ipopt.max_iter": 1000,
    "calc_lam_p": False,
    "no_nlp_grad": True,
}
_PER_STAGE = 8
"""Entries of a stage beside its controls: xi and the next state."""
_RATE_SCALE = 10.0


def _rate(x: ca.SX, torque: ca.SX, inertia: Floats) -> ca.SX:
    q, w = x[:4], x[4:]
    turning = 0.5 * ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w))
    j = ca.DM(inertia)
    return ca.vertcat(turning, ca.solve(j, torque - ca.cross(w, j @ w)))


def step_function(task: SlewTask) -> ca.Function:
    """One RK4 step of an interval, (state, scaled thrusters) -> state."""
    x, u = ca.SX.sym("x", 7), ca.SX.sym("u", task.size)
    torque = ca.DM(task.mounting.to_external * task.scale) @ u
    h, inertia = task.step, np.asarray(task.craft.inertia)
    k1 = _rate(x, torque, inertia)
    k2 = _rate(x + h / 2 * k1, torque, inertia)
    k3 = _rate(x + h / 2 * k2, torque, inertia)
    k4 = _rate(x + h * k3, torque, inertia)
    end = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("step", [x, u], [ca.vertcat(end[:4] / ca.norm_2(end[:4]), end[4:])])


def program(task: SlewTask, step: ca.Function) -> dict[str, ca.MX]:
    """Variables: controls, xi and the next state, interval by interval."""
    n, b = task.intervals, task.size
    variables = ca.MX.sym("variables", (b + _PER_STAGE) * n)
    stages = ca.reshape(variables, b + _PER_STAGE, n)
    controls, xi, states = stages[:b, :], stages[b, :], stages[b + 1 :, :]
    begin = ca.horzcat(ca.MX(ca.DM(np.asarray(task.arguments.plant.start))), states[:, :-1])
    gaps = step.map(n)(begin, controls) - states
    u, s = ca.SX.sym("u", b), ca.SX.sym("s")
    path = ca.Function("path", [u, s], [u * s]).map(n)(controls, xi)
    x, r = ca.SX.sym("x", 7), np.asarray(task.target.q_ob)
    error = r[0] * x[1:4] - x[0] * ca.DM(r[1:]) - ca.cross(ca.DM(r[1:]), x[1:4])
    terminal = ca.Function("terminal", [x], [ca.vertcat(2.0 * error, _RATE_SCALE * x[4:])])
    return {
        "x": variables,
        "f": ca.sum2(1.0 - xi),
        "g": ca.veccat(gaps, path, terminal(states[:, -1])),
    }


def bounds(task: SlewTask) -> dict[str, Floats]:
    """Bounds of the variables and rows of `program`."""
    n, b = task.intervals, task.size
    most = np.full(b * n, task.goal.epsilon / float(task.scale.max()))
    return {
        "lbx": np.tile(np.r_[np.zeros(b + 1), np.full(7, -np.inf)], n),
        "ubx": np.tile(np.r_[np.ones(b + 1), np.full(7, np.inf)], n),
        "lbg": np.r_[np.zeros(7 * n), -most, np.zeros(6)],
        "ubg": np.r_[np.zeros(7 * n), most, np.zeros(6)],
    }


def guess(task: SlewTask, step: ca.Function, seed: int, index: int) -> Floats:
    """Two bursts of random length, either way round, flown; as variables of `program`."""
    rng = np.random.default_rng([seed, index])
    n, b = task.intervals, task.size
    q, r = np.asarray(task.start.q_ob), np.asarray(task.target.q_ob)
    axis = q[0] * r[1:] - r[0] * q[1:] - np.cross(q[1:], r[1:])
    axis *= rng.choice([-1.0, 1.0]) / np.linalg.norm(axis)
    wanted = np.asarray(task.craft.inertia) @ axis
    pull = wanted @ task.mounting.to_external
    length = int(rng.integers(max(1, n // 20), n // 12 + 1))
    u = np.zeros((n, b))
    u[:length] = np.where(pull > 0.0, pull / pull.max(), 0.0)
    u[n - length :] = np.where(pull < 0.0, -pull / pull.max(), 0.0)
    u *= rng.uniform(0.8, 1.0, (n, 1))
    states, x = [], np.asarray(task.arguments.plant.start)
    for row in u:
        x = np.asarray(step(x, row)).ravel()
        states.append(x)
    size = u.max(axis=1) * float(task.scale.max())
    xi = np.minimum(1.0, task.goal.epsilon / np.maximum(size, task.goal.epsilon))
    return np.column_stack([u, xi, np.array(states)]).ravel()


def prepare(case: str, seed: int, folder: Path) -> Solve:
    """Build everything and return the solver of single starts."""
    task = task_of(case)
    assert isinstance(task, SlewTask)
    step = step_function(task)
    solver = compiled_solver("ipopt", program(task, step), OPTIONS, folder)
    limits = bounds(task)

    def solve(index: int) -> Attempt:
        answer = solver(x0=guess(task, step, seed, index), **limits)
        stages = np.asarray(answer["x"]).reshape(task.intervals, task.size + _PER_STAGE)
        stats = solver.stats()
        controls = stages[:, : task.size] * task.scale
        return Attempt(controls, stats["return_status"], stats["iter_count"])

    return solve
