"""The thesis's chain: PD flight, then L1 from its states, then L0 from the L1 states alone.

    python -m benchmarks.casadi_worker hypso1-90-45-15 2 0 out.npz --method thesis-chain
    python -m benchmarks.casadi_worker hypso1-90-45-15 2 0 out.npz --method thesis-chain-warm

As printed: direct multiple shooting with one Runge-Kutta step an interval, orbit and wheel speeds
among the states, the target in the cost, the slacks of (5.7) and the complementarity of (5.3), the
default options of IPOPT and CasADi's default guess of zero for torque, slacks and xi.  Apart from
the text: the rate relative to the orbit is algebraic (4.3), because (4.20c) counts the transport
term twice and its answers miss the target by degrees; lengths are in units of the orbit's radius;
and both programs are expanded and compiled, which the source does not mention.

The chain has no random part: every start repeats it, so ask for as many as timings are wanted.

IPOPT's path through these programs is chaotic: equivalent codings end at different local minima.
For (90, 45, 15) this one solves L1 in 39 iterations, as printed, and L0 from its states then falls
into not moving (J = 31.66).  With the rate relative to the orbit as a state of its own, without
the doubled term, L0 was not done after 1500 iterations; from the PD states, with no L1 between, it
finds two intervals in 1176.  The second command above is not printed: it hands the torques of L1
on too, and finds two intervals.

Source: Schaanning (2021), sections 5.2 and 5.4, eqs. (2.48), (4.1) to (4.20), (5.3), (5.7), (5.8).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from benchmarks.attempts import Attempt, Solve
from benchmarks.casadi_compiled import compiled_solver
from benchmarks.cases import scenario_of
from jaxatt.problems.hands_off.build import build_slew
from jaxatt.problems.hands_off.pd_flight import fly_pd
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.surroundings import surroundings_of

Floats = npt.NDArray[np.float64]

SMOOTHING = 1e-8
"""alpha of (2.48); not stated in the source."""

OPTIONS: dict[str, Any] = {}
"""The source uses the defaults."""

_FLAGS = ("-O1", "-march=native", "-fPIC", "-shared")


def to_body(q: ca.SX, v: ca.SX) -> ca.SX:
    """Orbit components of a vector (3,) in body components, q = q_ob (4,)."""
    once = ca.cross(q[1:4], v)
    return v - 2.0 * (q[0] * once - ca.cross(q[1:4], once))


def orbit_rate(position: ca.SX, velocity: ca.SX) -> ca.SX:
    """omega_io in orbit axes, (3,) [rad/s]; (4.4)."""
    momentum = ca.cross(position, velocity)
    return ca.vertcat(0.0, -ca.norm_2(momentum) / ca.dot(position, position), 0.0)


class Chain:
    """The two programs of one slew.

    States, (10 + n + 3,): q_ob, omega_ib [rad/s], omega_bw [rad/s] of n wheels, position and
    velocity in units of the first radius.
    """

    def __init__(self, case: str):
        scenario = scenario_of(case)
        task = build_slew(scenario)
        assert isinstance(task, SlewTask)
        self.task, self.craft = task, task.craft
        around = surroundings_of(scenario)
        position, velocity, _ = around.motion.at(np.zeros(()))
        radius = float(np.linalg.norm(position))
        self.orbit_start = np.concatenate([position, velocity]) / radius
        self.mu = float(around.motion.mu) / radius**3
        begin = task.start
        self.attitude_start = np.concatenate([begin.q_ob, begin.omega_ib, begin.omega_bw])
        self.size = len(self.attitude_start) + 6
        self.step = self.runge_kutta()

    def derivative(self, x: ca.SX, torque: ca.SX) -> ca.SX:
        """Right-hand side of (5.1b) to (5.1g); torque (3,) [N m] on the wheels, body axes."""
        craft, wheels = self.craft, self.craft.wheels
        axes, wheel_inertia = np.asarray(wheels.axes), np.asarray(wheels.inertia)
        n = wheels.count
        q, w, speed = x[:4], x[4:7], x[7 : 7 + n]
        position, velocity = x[7 + n : 10 + n], x[10 + n :]
        relative = w - to_body(q, orbit_rate(position, velocity))
        wheel_torque = ca.DM(np.asarray(wheels.allocation)) @ torque
        momentum = ca.DM(np.asarray(craft.inertia)) @ w + ca.DM(axes * wheel_inertia) @ speed
        inverse = ca.DM(np.linalg.inv(np.asarray(craft.inertia_without_spin)))
        w_rate = inverse @ (-ca.DM(axes) @ wheel_torque - ca.cross(w, momentum))
        return ca.vertcat(
            -0.5 * ca.dot(q[1:4], relative),
            0.5 * (q[0] * relative + ca.cross(q[1:4], relative)),
            w_rate,
            wheel_torque / ca.DM(wheel_inertia) - ca.DM(axes.T) @ w_rate,
            velocity,
            -self.mu * position / ca.norm_2(position) ** 3,
        )

    def runge_kutta(self) -> ca.Function:
        """One step of the classical method over an interval, (x, torque) -> x."""
        x, torque, h = ca.SX.sym("x", self.size), ca.SX.sym("torque", 3), self.task.step
        k1 = self.derivative(x, torque)
        k2 = self.derivative(x + h / 2 * k1, torque)
        k3 = self.derivative(x + h / 2 * k2, torque)
        k4 = self.derivative(x + h * k3, torque)
        return ca.Function("step", [x, torque], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])

    def terminal_cost(self) -> ca.Function:
        """k1 f + k2 g of (5.2), the absolute value smoothed by (2.48)."""
        x = ca.SX.sym("x", self.size)
        target, weights = self.task.target, self.task.goal.weights
        n = self.craft.wheels.count
        relative = x[4:7] - to_body(x[:4], orbit_rate(x[7 + n : 10 + n], x[10 + n :]))
        along = ca.dot(x[:4], ca.DM(np.asarray(target.q_ob)))
        distance = 1.0 - ca.sqrt(along**2 + SMOOTHING / 4.0)
        rate = ca.sumsqr(relative - ca.DM(np.asarray(target.omega_ob)))
        return ca.Function("cost", [x], [weights.rate * rate + weights.attitude * distance])

    def program(self, kind: str) -> tuple[dict[str, ca.MX], dict[str, Floats]]:
        """Program (5.7) for "l1", (5.3) for "l0", and its bounds.

        Variables: states (N + 1), torques (N, 3) [N m], then the slacks or xi (N,).
        """
        n, size = self.task.intervals, self.size
        variables = ca.MX.sym("variables", size * (n + 1) + 4 * n)
        states = ca.reshape(variables[: size * (n + 1)], size, n + 1)
        torque = ca.reshape(variables[size * (n + 1) : size * (n + 1) + 3 * n], 3, n)
        extra = variables[size * (n + 1) + 3 * n :].T
        limit = np.asarray(self.craft.wheels.torque_limit)
        t, e = ca.SX.sym("t", 3), ca.SX.sym("e")
        # (5.7p) to (5.7r) as tau - s <= 0; (5.3q) to (5.3v) as xi tau <= eps, both signs.
        parts = (t - e, -t - e) if kind == "l1" else (e * t, -e * t)
        wheel = ca.DM(np.asarray(self.craft.wheels.allocation)) @ t
        path = ca.Function("path", [t, e], [ca.vertcat(wheel, *parts)]).map(n)(torque, extra)
        gaps = self.step.map(n)(states[:, :-1], torque) - states[:, 1:]
        start = ca.DM(np.concatenate([self.attitude_start, self.orbit_start]))
        sparsity = self.task.goal.weights.sparsity
        count = ca.sum2(extra) if kind == "l1" else ca.sum2(1.0 - extra)
        above = 0.0 if kind == "l1" else self.task.goal.epsilon
        lower = np.tile(np.r_[-limit, np.full(6, -np.inf)], n)
        upper = np.tile(np.r_[limit, np.full(6, above)], n)
        equal = np.zeros(size * (n + 1))
        free = np.full(size * (n + 1) + 3 * n, np.inf)
        ends = (-np.inf, np.inf) if kind == "l1" else (0.0, 1.0)
        return (
            {
                "x": variables,
                "f": self.terminal_cost()(states[:, -1]) + sparsity * count,
                "g": ca.veccat(states[:, 0] - start, gaps, path),
            },
            {
                "lbx": np.r_[-free, np.full(n, ends[0])],
                "ubx": np.r_[free, np.full(n, ends[1])],
                "lbg": np.r_[equal, lower],
                "ubg": np.r_[equal, upper],
            },
        )

    def orbit(self) -> Floats:
        """Position and velocity at the nodes, (N + 1, 6), by the step of the programs."""
        x = np.concatenate([self.attitude_start, self.orbit_start])
        nodes = [x[-6:]]
        for _ in range(self.task.intervals):
            x = np.asarray(self.step(x, np.zeros(3))).ravel()
            nodes.append(x[-6:])
        return np.array(nodes)

    def packed(self, attitude: Floats, torque: Floats | None = None) -> Floats:
        """A guess of the attitude states (N + 1, 7 + n) and torques (N, 3), else zero.

        The orbit, which no torque changes, is filled in.
        """
        n = self.task.intervals
        states = np.concatenate([attitude, self.orbit()], axis=1)
        known = np.zeros((n, 3)) if torque is None else torque
        return np.concatenate([states.ravel(), known.ravel(), np.zeros(n)])

    def unpacked(self, variables: ca.DM) -> tuple[Floats, Floats]:
        """Attitude states (N + 1, 7 + n) and torques (N, 3) of a solution."""
        n, flat = self.task.intervals, np.asarray(variables).ravel()
        states = flat[: self.size * (n + 1)].reshape(n + 1, self.size)
        torque = flat[self.size * (n + 1) : self.size * (n + 1) + 3 * n].reshape(n, 3)
        return states[:, :-6], torque


def flown_states(task: SlewTask) -> Floats:
    """Attitude states of the PD flight at nodes 0 to N, (N + 1, 7 + n); (5.8)."""
    flown, end = fly_pd(task), task.intervals + 1
    return np.concatenate([flown.q_ob[:end], flown.omega_ib[:end], flown.omega_bw[:end]], axis=1)


def prepare(case: str, seed: int, folder: Path, hand_torque_on: bool = False) -> Solve:
    """Build both programs and return the solver of the chain; the seed changes nothing.

    hand_torque_on : whether L0 starts from the torques of L1 too; not printed.
    """
    chain = Chain(case)
    solvers = {}
    for kind in ("l1", "l0"):
        program, limits = chain.program(kind)
        solvers[kind] = compiled_solver("ipopt", program, OPTIONS, folder, _FLAGS), limits

    def solve(index: int) -> Attempt:
        attitude, torque = flown_states(chain.task), None
        iterations, status = 0, []
        for solver, limits in solvers.values():
            answer = solver(x0=chain.packed(attitude, torque), **limits)
            attitude, found = chain.unpacked(answer["x"])
            torque = found if hand_torque_on else None
            iterations += solver.stats()["iter_count"]
            status.append(solver.stats()["return_status"])
        return Attempt(found, ", ".join(status), iterations)

    return solve


def prepare_warm(case: str, seed: int, folder: Path) -> Solve:
    """As `prepare`, with the torques handed on."""
    return prepare(case, seed, folder, hand_torque_on=True)
