"""Manoeuvres of bodies in motion with CasADi and IPOPT: least effort in a given time, least time.

Seven-state model with conserved momentum (`InertialManoeuvre`), multiple shooting, several
Runge-Kutta steps an interval, exact derivatives, mapped over the intervals and compiled.  All
numbers of a manoeuvre are parameters, so one program serves all cases of a kind.

A least-effort program has the largest body torque of every interval as a variable of its own (L1 of
Schaanning 2021, eq. 5.7).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.casadi_compiled import compiled_solver
from benchmarks.casadi_model import RATE_UNIT
from benchmarks.inertial_manoeuvre import InertialManoeuvre
from benchmarks.informed_starts import Start
from jaxatt.runtime.arrays import Floats

OPTIONS: dict[str, Any] = {
    "ipopt.tol": 1e-8,
    "ipopt.max_iter": 500,
    "ipopt.bound_push": 0.1,
    "ipopt.bound_frac": 0.1,
    "calc_lam_p": False,
    "no_nlp_grad": True,
}
_STATE = 7


@dataclass(frozen=True)
class Shape:
    """What is compiled in.

    size : controls b.  others : rows of further limits on them.  free_time : least time, else
    least effort.
    """

    intervals: int
    substeps: int
    size: int
    others: int
    free_time: bool

    @property
    def width(self) -> int:
        """Variables of an interval: controls, next state and, of least effort, its slack."""
        return self.size + _STATE + (not self.free_time)


@dataclass(frozen=True, eq=False)
class Ended:
    """What IPOPT returned: controls (N, b), an interval [s], its word and its work."""

    u: Floats
    step: float
    status: str
    iterations: int


def _interval(shape: Shape) -> ca.Function:
    """(x, u, h, parameters of the body) -> x after an interval, by classical Runge-Kutta steps."""
    x, u, h = ca.SX.sym("x", _STATE), ca.SX.sym("u", shape.size), ca.SX.sym("h")
    inverse, push = ca.SX.sym("inverse", 3, 3), ca.SX.sym("push", 3, shape.size)
    momentum = ca.SX.sym("momentum", 3)

    def slope(point: ca.SX) -> ca.SX:
        eta, eps, w = point[0], point[1:4], point[4:7] * RATE_UNIT
        once = ca.cross(eps, momentum)
        inside = momentum - 2.0 * (eta * once - ca.cross(eps, once))
        rate = ca.mtimes(inverse, ca.cross(inside, w)) - ca.mtimes(push, u)
        return ca.vertcat(
            -0.5 * ca.dot(eps, w), 0.5 * (eta * w + ca.cross(eps, w)), rate / RATE_UNIT
        )

    k1 = slope(x)
    k2 = slope(x + h / 2 * k1)
    k3 = slope(x + h / 2 * k2)
    k4 = slope(x + h * k3)
    body = (inverse, momentum, push)
    one = ca.Function("one", [x, u, h, *body], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])
    held = [ca.MX.sym(f"held{i}", *part.shape) for i, part in enumerate((u, h, *body))]
    first = state = ca.MX.sym("first", _STATE)
    for _ in range(shape.substeps):
        state = one(state, held[0], held[1] / shape.substeps, *held[2:])
    return ca.Function("interval", [first, *held], [state])


def _terminal() -> ca.Function:
    """(end, target, target's rate) -> errors (6,); both signs of a quaternion are one attitude."""
    end, target, rate = ca.SX.sym("end", _STATE), ca.SX.sym("target", 4), ca.SX.sym("rate", 3)
    off = target[0] * end[1:4] - target[1:4] * end[0] - ca.cross(target[1:4], end[1:4])
    return ca.Function("terminal", [end, target, rate], [ca.vertcat(off, end[4:7] - rate)])


def program(shape: Shape) -> dict[str, ca.MX]:
    """The program: its variables are the interval's length [s], then interval by interval.

    Its parameters are those of `_parameters`, column by column.
    """
    n, b = shape.intervals, shape.size
    variables = ca.MX.sym("variables", 1 + n * shape.width)
    sizes = (9, 3, 3 * b, 3 * b, shape.others * b, _STATE, 4, 3)
    parameters = ca.MX.sym("p", sum(sizes))
    parts = ca.vertsplit(parameters, [0, *np.cumsum(sizes).tolist()])
    inverse, momentum = ca.reshape(parts[0], 3, 3), parts[1]
    push, torque = ca.reshape(parts[2], 3, b), ca.reshape(parts[3], 3, b)
    others, start, target, rate = ca.reshape(parts[4], shape.others, b), *parts[5:]
    step, stages = variables[0], ca.reshape(variables[1:], shape.width, n)
    controls, states = stages[:b, :], stages[b : b + _STATE, :]
    begin = ca.horzcat(start, states[:, :-1])
    repeated = [ca.repmat(part, 1, n) for part in (step, inverse, momentum, push)]
    gaps = _interval(shape).map(n)(begin, controls, *repeated) - states
    rows = [ca.vec(gaps), _terminal()(states[:, -1], target, rate)]
    if shape.others:
        rows.append(ca.vec(others @ controls))
    if shape.free_time:
        return {"x": variables, "p": parameters, "f": n * step, "g": ca.vertcat(*rows)}
    slack = stages[b + _STATE, :]
    size = ca.repmat(slack, 3, 1)
    rows += [ca.vec(torque @ controls - size), ca.vec(-(torque @ controls) - size)]
    return {"x": variables, "p": parameters, "f": ca.sum2(slack), "g": ca.vertcat(*rows)}


def _parameters(m: InertialManoeuvre) -> Floats:
    """Values of the parameters of `program`."""
    unit = np.abs(m.to_body).max()
    state = np.concatenate([m.start, m.start_rate / RATE_UNIT])
    parts = (
        m.inverse_inertia,
        m.momentum,
        m.inverse_inertia @ m.to_body,
        m.to_body / unit,
        m.others,
        state,
        m.target,
        m.target_rate / RATE_UNIT,
    )
    return np.concatenate([np.ravel(part, order="F") for part in parts])


class Solver:
    """IPOPT over one compiled program."""

    def __init__(self, shape: Shape, folder: Path) -> None:
        self.shape = shape
        self._solver = compiled_solver("ipopt", program(shape), OPTIONS, folder)

    def __call__(self, manoeuvre: InertialManoeuvre, start: Start) -> Ended:
        """Solve from one start."""
        shape, n, b = self.shape, self.shape.intervals, self.shape.size
        states = start.states[1:] / np.r_[np.ones(4), np.full(3, RATE_UNIT)]
        columns = [start.u, states]
        low, high = -np.ones(b), np.ones(b)
        low = np.r_[low, np.full(shape.width - b, -np.inf)]
        high = np.r_[high, np.full(shape.width - b, np.inf)]
        gaps = np.zeros(n * _STATE + 6)
        below, above = [gaps, np.full(n * shape.others, -1.0)], [gaps, np.ones(n * shape.others)]
        steps = (1e-3 * start.step, np.inf) if shape.free_time else (start.step, start.step)
        if not shape.free_time:
            unit = np.abs(manoeuvre.to_body).max()
            columns.append(np.abs(start.u @ manoeuvre.to_body.T).max(axis=1, keepdims=True) / unit)
            low[-1] = 0.0
            below.append(np.full(6 * n, -np.inf))
            above.append(np.zeros(6 * n))
        answer = self._solver(
            x0=np.r_[start.step, np.column_stack(columns).ravel()],
            p=_parameters(manoeuvre),
            lbx=np.r_[steps[0], np.tile(low, n)],
            ubx=np.r_[steps[1], np.tile(high, n)],
            lbg=np.concatenate(below),
            ubg=np.concatenate(above),
        )
        found, stats = np.asarray(answer["x"]).ravel(), self._solver.stats()
        u = found[1:].reshape(n, shape.width)[:, :b]
        return Ended(u, float(found[0]), stats["return_status"], stats["iter_count"])
