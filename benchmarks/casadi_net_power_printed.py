"""Chapter 4's manoeuvre as it is printed, with CasADi and IPOPT or FATROP.

Ten states, q_ib, omega_ib and the wheels' speeds, one Runge-Kutta step an interval that integrates
the power along with them, the wheels' power signed; attitude and rate at the end as equations in
place of the printed cost, as on the other sides.  Numbers of `benchmarks.net_power`.

Source: Kristiansen (2023), eqs. (4.1), (4.4), (4.6) and (4.9).
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.attempts import Floats
from benchmarks.casadi_compiled import compiled_solver
from benchmarks.casadi_net_power import FATROP, IPOPT, Ended
from benchmarks.net_power import HORIZON_S, INTERVALS, PARAMETERS, START

_UNIT = PARAMETERS["torque"]
_ENERGY = 10.0
"""[J] of a unit of the cost."""


def _slope(x: ca.SX, u: ca.SX) -> ca.SX:
    """Derivative of the state, and of the energy gained."""
    p, torque = PARAMETERS, _UNIT * u
    q, rate, wheels = x[:4], x[4:7], x[7:10]
    squared = ca.sumsqr(q)
    turned = ca.vertcat(-ca.dot(q[1:], rate), q[0] * rate + ca.cross(q[1:], rate))
    momentum = ca.DM(p["inertia"]) @ rate + p["wheel"] * wheels
    change = ca.DM(p["inverse"]) @ (-ca.cross(rate, momentum) - torque)
    # The power reads the attitude, which a quaternion of any length has.
    unit, sun = q / ca.sqrt(squared), ca.DM(p["sun"])
    once = ca.cross(unit[1:], sun)
    seen = sun - 2.0 * unit[0] * once + 2.0 * ca.cross(unit[1:], once)
    toward = ca.vertcat(seen, -seen)
    lit = 0.5 * (toward + ca.sqrt(toward**2 + p["smoothing"]))
    earned = p["irradiance"] * ca.dot(lit * toward, ca.DM(p["areas"]))
    power = earned - ca.dot(torque, wheels) / p["efficiency"]
    return ca.vertcat(
        0.5 * turned + 0.5 * p["baumgarte"] * q * (1.0 / squared - 1.0),
        change,
        torque / p["wheel"] - change,
        power / _ENERGY,
    )


def _interval() -> ca.Function:
    """(state, control) -> next state, and the energy gained over `_ENERGY`."""
    x, u, h = ca.SX.sym("x", 10), ca.SX.sym("u", 3), HORIZON_S / INTERVALS
    k1 = _slope(x, u)
    k2 = _slope(x + h / 2 * k1[:10], u)
    k3 = _slope(x + h / 2 * k2[:10], u)
    k4 = _slope(x + h * k3[:10], u)
    rise = h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return ca.Function("interval", [x, u], [x + rise[:10], rise[10]])


def _program(start_rows: bool) -> dict[str, ca.MX]:
    """Variables: state and control of every interval, then the last state."""
    n = INTERVALS
    variables = ca.MX.sym("variables", 13 * n + 10)
    stages, last = ca.reshape(variables[: 13 * n], 13, n), variables[13 * n :]
    states, controls = stages[:10, :], stages[10:, :]
    after, gained = _interval().map(n)(states, controls)
    gaps = ca.horzcat(states[:, 1:], last) - after
    q, r = last[:4], ca.DM(PARAMETERS["target"])
    error = r[0] * q[1:] - q[0] * r[1:] - ca.cross(r[1:], q[1:])
    start = [states[:, 0] - ca.DM(START)] if start_rows else []
    rows = [gaps[:, 0], *start, gaps[:, 1:], 2.0 * error, 10.0 * last[4:7]]
    return {"x": variables, "f": -ca.sum2(gained), "g": ca.veccat(*rows)}


class PrintedSolver:
    """The manoeuvre with one method, "ipopt" or "fatrop", compiled into a folder."""

    def __init__(self, method: str, folder: Path) -> None:
        """Build and compile."""
        self.method, n = method, INTERVALS
        rows = method == "fatrop"
        options: dict[str, Any] = dict(IPOPT)
        if rows:
            options = {
                "structure_detection": "manual",
                "N": n,
                "nx": [10] * (n + 1),
                "nu": [3] * n + [0],
                "ng": [10] + [0] * (n - 1) + [6],
                "equality": [True] * (10 + 10 * n + 6),
                "fatrop": FATROP,
            }
        self.function = compiled_solver(method, _program(rows), options, folder)
        free, one = np.full(10, np.inf), np.ones(3)
        lower = np.r_[np.tile(np.r_[-free, -one], n), -free]
        upper = -lower
        if not rows:
            lower[:10] = upper[:10] = START
        self.limits = {"lbx": lower, "ubx": upper, "lbg": 0.0, "ubg": 0.0}

    def __call__(self, u: Floats, x: Floats) -> Ended:
        """Solve from scaled torques (N, 3) and states (N + 1, 7), q_ib and the rate that the wheels
        have taken from a body without momentum."""
        rate = -x[:, 4:7]
        wheels = -rate @ PARAMETERS["inertia"] / PARAMETERS["wheel"]
        states = np.concatenate([x[:, :4], rate, wheels], axis=1)
        guess = np.r_[np.concatenate([states[:-1], u], axis=1).ravel(), states[-1]]
        began = time.process_time()
        answer = self.function(x0=guess, **self.limits)
        spent = time.process_time() - began
        stages = np.asarray(answer["x"]).ravel()[:-10].reshape(INTERVALS, 13)
        stats = self.function.stats()
        word = "return_status" if self.method == "ipopt" else "unified_return_status"
        return Ended(
            _UNIT * stages[:, 10:],
            str(stats[word]),
            int(stats["iter_count"]),
            spent,
            _ENERGY * float(answer["f"]),
        )
