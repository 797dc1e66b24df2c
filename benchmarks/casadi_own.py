"""The problems of `own_programmes` in CasADi: multiple shooting, the same Runge-Kutta step, IPOPT.

The program is built as a user builds it: a step in scalar expressions, mapped over the intervals.
`compiled` turns it and its exact derivatives into C first, which is IPOPT's strongest form here.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks import net_power
from benchmarks.casadi_compiled import compiled_solver

OPTIONS: dict[str, Any] = {"ipopt.tol": 1e-8, "ipopt.max_iter": 1000}
_QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False}
Floats = np.ndarray


@dataclass(frozen=True)
class Model:
    """A problem in CasADi's terms; controls are scaled to [-1, 1] where they have limits.

    start : first state.  rate : (x, u) -> dx/dt.  cost : (x, u) -> running cost.
    missed : x -> zero at the end.  final_time : [s], None where it is free and the cost.
    limited : whether controls lie between -1 and 1.  upper : of the states.
    """

    start: Floats
    controls: int
    intervals: int
    rate: Callable[[ca.SX, ca.SX], ca.SX]
    missed: Callable[[ca.MX], ca.MX]
    cost: Callable[[ca.SX, ca.SX], ca.SX] | None = None
    final_time: float | None = None
    limited: bool = True
    upper: Floats | None = None


@dataclass(frozen=True)
class Answer:
    """What IPOPT says of a start, and its CPU time [s]."""

    solved: bool
    objective: float
    iterations: int
    cpu_s: float


class Solver:
    """A model built, and compiled if a folder is given; called with starts."""

    def __init__(self, model: Model, folder: Path | None = None) -> None:
        began = time.process_time(), time.perf_counter()
        self.model, s, b, n = model, len(model.start), model.controls, model.intervals
        x, u, h = ca.SX.sym("x", s), ca.SX.sym("u", b), ca.SX.sym("h")

        def both(x: ca.SX) -> ca.SX:
            cost = ca.SX(0.0) if model.cost is None else model.cost(x, u)
            return ca.vertcat(model.rate(x, u), cost)

        k1 = both(x)
        k2 = both(x + 0.5 * h * k1[:s])
        k3 = both(x + 0.5 * h * k2[:s])
        k4 = both(x + h * k3[:s])
        moved = h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        step = ca.Function("step", [x, u, h], [x + moved[:s], moved[s]])
        variables = ca.MX.sym("variables", 1 + n * (s + b))
        log_time = variables[0]
        final = ca.exp(log_time) if model.final_time is None else model.final_time
        stages = ca.reshape(variables[1:], s + b, n)
        controls, states = stages[:b, :], ca.horzcat(ca.DM(model.start), stages[b:, :])
        ahead, cost = step.map(n)(states[:, :n], controls, ca.repmat(final / n, 1, n))
        rows = ca.vertcat(ca.vec(ahead - states[:, 1:]), model.missed(states[:, n]))
        objective = final if model.final_time is None else ca.sum2(cost)
        program = {"x": variables, "f": objective, "g": rows}
        if folder is None:
            self.function = ca.nlpsol("solver", "ipopt", program, {**_QUIET, **OPTIONS})
        else:
            self.function = compiled_solver("ipopt", program, OPTIONS, folder)
        limit = np.full(b, 1.0 if model.limited else np.inf)
        above = np.full(s, np.inf) if model.upper is None else model.upper
        fixed = 0.0 if model.final_time is not None else np.inf
        self.lower = np.r_[-fixed, np.tile(np.r_[-limit, np.full(s, -np.inf)], n)]
        self.upper = np.r_[fixed, np.tile(np.r_[limit, above], n)]
        self.build_cpu_s = time.process_time() - began[0]
        self.build_s = time.perf_counter() - began[1]

    def __call__(self, u: Floats, x: Floats, final_time: float) -> Answer:
        """From scaled controls (N, b), states (N + 1, s) and a final time [s]."""
        stages = np.concatenate([u, x[1:]], axis=1).ravel()
        first = np.log(final_time) if self.model.final_time is None else 0.0
        began = time.process_time()
        found = self.function(
            x0=np.r_[first, stages], lbx=self.lower, ubx=self.upper, lbg=0.0, ubg=0.0
        )
        spent = time.process_time() - began
        stats = self.function.stats()
        solved = stats["return_status"] == "Solve_Succeeded"
        return Answer(solved, float(found["f"]), stats["iter_count"], spent)


def _brachistochrone(intervals: int) -> Model:
    half = 0.5 * np.pi

    def rate(x: ca.SX, u: ca.SX) -> ca.SX:
        return ca.vertcat(
            x[2] * ca.cos(half * u), x[2] * ca.sin(half * u), 9.80665 * ca.sin(half * u)
        )

    return Model(np.zeros(3), 1, intervals, rate, lambda x: x[:2] - ca.DM([10.0, 5.0]))


def _bryson_denham(intervals: int) -> Model:
    return Model(
        np.array([0.0, 1.0]),
        1,
        intervals,
        lambda x, u: ca.vertcat(x[1], u),
        lambda x: x - ca.DM([0.0, -1.0]),
        cost=lambda x, u: 0.5 * u**2,
        final_time=1.0,
        limited=False,
        upper=np.array([1.0 / 9.0, np.inf]),
    )


def _double_integrator(intervals: int) -> Model:
    return Model(
        np.zeros(2),
        1,
        intervals,
        lambda x, u: ca.vertcat(x[1], u),
        lambda x: x - ca.DM([1.0, 0.0]),
    )


def _turned(q: ca.MX, target: Floats) -> ca.MX:
    r = ca.DM(target)
    return 2.0 * (r[0] * q[1:] - q[0] * r[1:] - ca.cross(r[1:], q[1:]))


def _kinematics(q: ca.SX, w: ca.SX) -> ca.SX:
    return 0.5 * ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w))


def _rigid_body(intervals: int) -> Model:
    return Model(
        np.r_[1.0, np.zeros(6)],
        3,
        intervals,
        lambda x, u: ca.vertcat(_kinematics(x[:4], x[4:]), u),
        lambda x: ca.vertcat(_turned(x[:4], np.array([0.0, 0.0, 0.0, 1.0])), x[4:]),
    )


def _net_power(intervals: int) -> Model:
    p = net_power.PARAMETERS
    inertia, wheel = p["inertia"], p["wheel"]
    body = ca.DM(p["inverse"])

    def rate(x: ca.SX, u: ca.SX) -> ca.SX:
        q, w, wheels = x[:4], x[4:7], x[7:]
        momentum = ca.DM(inertia) @ w + wheel * wheels
        change = body @ (-ca.cross(w, momentum) - p["torque"] * u)
        steady = 0.5 * p["baumgarte"] * q * (1.0 / ca.sumsqr(q) - 1.0)
        return ca.vertcat(_kinematics(q, w) + steady, change, p["torque"] * u / wheel - change)

    def cost(x: ca.SX, u: ca.SX) -> ca.SX:
        q, wheels, v = x[:4], x[7:], ca.DM(p["sun"])
        once = ca.cross(q[1:], v)
        sun = v - 2.0 * q[0] * once + 2.0 * ca.cross(q[1:], once)
        toward = ca.vertcat(sun, -sun)
        lit = 0.5 * (toward + ca.sqrt(toward**2 + p["smoothing"]))
        earned = p["irradiance"] * ca.dot(lit * toward, ca.DM(p["areas"]))
        return -earned - p["torque"] * ca.dot(u, wheels) / p["efficiency"]

    return Model(
        net_power.START,
        3,
        intervals,
        rate,
        lambda x: ca.vertcat(_turned(x[:4], p["target"]), 10.0 * x[4:7]),
        cost=cost,
        final_time=net_power.HORIZON_S,
    )


MODELS: dict[str, Callable[[int], Model]] = {
    "brachistochrone": _brachistochrone,
    "Bryson-Denham": _bryson_denham,
    "double integrator": _double_integrator,
    "rigid body": _rigid_body,
    "net power": _net_power,
}
"""By the names of `own_programmes`: function of the number of intervals."""
