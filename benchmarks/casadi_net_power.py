"""Manoeuvres that earn energy, with CasADi: IPOPT, and FATROP where it takes the program.

The transcription of the package, written a second time: states q_ib, the rate that the wheels have
taken from the body and, with external torques, the total momentum in inertial axes; one step an
interval by a Magnus expansion; the sun weighed at the nodes; magnitudes of the wheels' power as a
variable with two inequalities; attitude and rate at the end as equations.  Only numbers come from
the package: the parameters of the manoeuvre, and the starts.  Everything is expanded, mapped over
the intervals and compiled, with exact derivatives.

Source: Kristiansen (2023), eqs. (4.9) and (5.11), with the package's readings.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.attempts import Floats
from benchmarks.casadi_compiled import compiled_solver
from jaxatt.problems.net_power.wheels.task import WheelsTask

IPOPT: dict[str, Any] = {
    "ipopt.tol": 1e-6,
    "ipopt.mu_init": 1e-2,
    "ipopt.max_iter": 1000,
    "calc_lam_p": False,
    "no_nlp_grad": True,
}
FATROP: dict[str, Any] = {"print_level": 0, "tol": 1e-6, "mu_init": 1e-2, "max_iter": 1000}


def cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """Vector product."""
    return ca.cross(a, b)


def product(p: ca.SX, q: ca.SX) -> ca.SX:
    """Product of two quaternions, scalar first."""
    scalar = p[0] * q[0] - ca.dot(p[1:], q[1:])
    return ca.vertcat(scalar, p[0] * q[1:] + q[0] * p[1:] + cross(p[1:], q[1:]))


def exponential(turn: ca.SX) -> ca.SX:
    """Quaternion of a rotation vector, smooth at zero."""
    angle = ca.sqrt(ca.sumsqr(turn) + 1e-30)
    return ca.vertcat(ca.cos(0.5 * angle), ca.sin(0.5 * angle) / angle * turn)


def to_body(q: ca.SX, v: ca.SX) -> ca.SX:
    """R(q)' v."""
    once = cross(q[1:], v)
    return v - 2.0 * q[0] * once + 2.0 * cross(q[1:], once)


def to_inertial(q: ca.SX, v: ca.SX) -> ca.SX:
    """R(q) v."""
    return to_body(ca.vertcat(q[0], -q[1:]), v)


def rotation_vector(rate: ca.SX, slope: ca.SX, bend: ca.SX, h: float) -> ca.SX:
    """Sixth-order Magnus expansion for a rate with two derivatives; Blanes and Casas (2016)."""
    first = h * (rate + 0.5 * h * (slope + 0.25 * h * bend))
    second = h * h * (slope + 0.5 * h * bend)
    third = 0.5 * h**3 * bend
    both = cross(first, second)
    left = 20.0 * first + third + both
    right = -second + cross(first, both - 2.0 * third) / 60.0
    return first + third / 12.0 - cross(left, right) / 240.0


@dataclass(frozen=True, eq=False)
class Interval:
    """One interval: (state, control, stage) -> next state, cost and inequality rows."""

    step: ca.Function
    rows: int


def stage_data(task: WheelsTask) -> Floats:
    """What changes from interval to interval, (rows, N): sun, its light, down, gradient, field."""
    stages = task.parameters.stages
    parts = [np.asarray(stages.sun).T, np.asarray(stages.shone)[None]]
    if task.form.torqued:
        along = stages.along
        parts += [np.stack([np.asarray(x)[:, 0] for x in along.down.parts])]
        parts += [np.asarray(along.gradient)[:, :1].T]
        parts += [np.stack([np.asarray(x)[:, 0] for x in along.field.parts])]
    return np.concatenate(parts)


def collecting_area(task: WheelsTask, sun_b: ca.SX) -> ca.SX:
    """Equations (4.4) and (5.4), the positive part smoothed by (2.11)."""
    p = task.parameters
    panels, alpha = p.panels, float(p.smoothing)
    cosine = ca.DM(np.asarray(panels.normals).T) @ sun_b
    lit = 0.5 * (cosine + ca.sqrt(cosine**2 + alpha))
    value = lit * cosine if panels.incidence_exponent == 2 else lit
    value = ca.DM(np.asarray(panels.area) * np.asarray(panels.efficiency)) * value
    own = ca.DM(np.asarray(panels.shades, float))
    return ca.dot(own, value) + (1.0 - ca.dot(own, lit)) * ca.dot(1.0 - own, value)


def interval(task: WheelsTask) -> Interval:
    """Dynamics, cost and inequalities of an interval, for one step in it."""
    p, form = task.parameters, task.form
    if form.substeps != 1 or form.each or form.charge or form.power == "wheels":
        raise ValueError("form: this side has one step an interval and signed or body power")
    h = task.manoeuvre.step
    size = 10 if form.torqued else 7
    x, u = ca.SX.sym("x", size), ca.SX.sym("u", form.controls)
    data = ca.SX.sym("data", len(stage_data(task)))
    q, lost, scaled = x[:4], x[4:7], u[: form.wheels]
    inverse, without = ca.DM(np.asarray(p.inverse)), ca.DM(np.asarray(p.without_spin))
    taking = ca.DM(np.asarray(p.to_stored)) @ scaled
    total = float(p.momentum_scale) * x[7:] if form.torqued else ca.DM(np.asarray(p.total))
    still = form.momentum == "zero"
    momentum = ca.SX.zeros(3) if still else to_body(q, total)
    rate = inverse @ momentum - lost
    change = cross(momentum, rate)
    slope = inverse @ change - taking
    dipole = torque = ca.SX.zeros(3)
    if form.torqued:
        torque, dipole = external(task, q, lost, taking, rate, slope, data)
        change, slope = change + torque, slope + inverse @ torque
    bend = inverse @ (cross(change, rate) + cross(momentum, slope))
    turn = exponential(rotation_vector(rate, slope, bend, h))
    after = [product(q, turn), lost + h * taking]
    if form.torqued:
        middle = exponential(0.5 * h * rate + 0.125 * h * h * slope)
        push = to_inertial(q, h * to_inertial(middle, torque))
        after.append(x[7:] + push / float(p.momentum_scale))
    cost = -data[3] * collecting_area(task, to_body(q, data[:3]))
    cost += h * float(p.effort) * ca.sumsqr(scaled)
    rows = []
    if form.powers:
        axes = ca.DM(np.asarray(p.axes))
        pushed = axes @ (ca.DM(np.asarray(p.torque_limit)) * scaled)
        beyond = total if not form.torqued else float(p.momentum_scale) * after[2]
        later = lost + h * taking
        at_end = -later if still else inverse @ to_body(after[0], beyond) - later
        for late, (taken, omega) in enumerate(((lost, rate), (later, at_end))):
            magnitude = u[form.wheels + late]
            spun = without @ taken / float(p.wheel_inertia[0])
            power = ca.dot(pushed, spun - axes @ axes.T @ omega) / float(p.power_scale)
            rows += [magnitude - float(p.taken) * power, magnitude + float(p.returned) * power]
            cost += 0.5 * h * float(p.power_scale) * magnitude
    if form.magnetorquers == "managing":
        rounding = float(p.rounding)
        sizes = ca.sqrt(dipole**2 + rounding**2) - rounding
        cost += h * ca.dot(ca.DM(np.asarray(p.dipole_price)), sizes)
        cost += h * ca.dot(ca.DM(np.asarray(p.dipole_loss)), dipole**2)
    outputs = [ca.vertcat(*after), cost / float(p.energy_scale), ca.vertcat(ca.SX(0, 1), *rows)]
    return Interval(ca.Function("interval", [x, u, data], outputs), len(rows))


def external(
    task: WheelsTask, q: ca.SX, lost: ca.SX, taking: ca.SX, rate: ca.SX, slope: ca.SX, data: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """External torque in body axes and dipole of the magnetorquers, in the middle."""
    p, h = task.parameters, task.manoeuvre.step
    middle = product(q, exponential(0.5 * h * rate + 0.125 * h * h * slope))
    omega = rate + 0.5 * h * slope
    inertia, without = ca.DM(np.asarray(p.inertia)), ca.DM(np.asarray(p.without_spin))
    down, gradient, field = to_body(middle, data[4:7]), data[7], to_body(middle, data[8:11])
    dipole = ca.SX.zeros(3)
    if p.management is not None:
        relative = without @ (lost + 0.5 * h * taking) - (inertia - without) @ omega
        excess = relative - ca.DM(np.asarray(p.management.kept))
        limit = ca.DM(np.asarray(p.management.dipole_limit))
        wanted = float(p.management.law.gain) * cross(excess, field) / ca.norm_2(field)
        dipole = ca.fmin(ca.fmax(wanted, -limit), limit)
    torque = gradient * cross(down, inertia @ down) + cross(dipole, field)
    if p.torques.residual_dipole is not None:
        torque += cross(ca.DM(np.asarray(p.torques.residual_dipole.dipole)), field)
    if p.torques.eddy_currents is not None:
        torque += float(p.torques.eddy_currents.coefficient) * cross(cross(omega, field), field)
    return torque, dipole


def ending(task: WheelsTask) -> ca.Function:
    """Last state -> its cost, and rows that vanish at the target: twice the vector part of the
    attitude's error, whatever the sign, and ten times that of the rate."""
    p, form = task.parameters, task.form
    x = ca.SX.sym("x", 10 if form.torqued else 7)
    q, r = x[:4], ca.DM(np.asarray(p.reference))
    error = r[0] * q[1:] - q[0] * r[1:] - cross(r[1:], q[1:])
    total = float(p.momentum_scale) * x[7:] if form.torqued else ca.DM(np.asarray(p.total))
    held = ca.SX.zeros(3) if form.momentum == "zero" else to_body(q, total)
    rate = ca.DM(np.asarray(p.inverse)) @ held - x[4:7]
    sun = to_body(q, ca.DM(np.asarray(p.last_sun)))
    cost = -float(p.last_shone) * collecting_area(task, sun) / float(p.energy_scale)
    missed = 10.0 * (rate - ca.DM(np.asarray(p.reference_rate)))
    return ca.Function("ending", [x], [cost, ca.vertcat(2.0 * error, missed)])


def program(task: WheelsTask, start_rows: bool) -> dict[str, ca.MX]:
    """Variables: state and control of every interval, then the last state.

    start_rows : whether the first state is fixed by rows, as FATROP wants, or by its bounds.
    """
    n, b = task.manoeuvre.intervals, task.form.controls
    size = 10 if task.form.torqued else 7
    variables = ca.MX.sym("variables", (size + b) * n + size)
    stages = ca.reshape(variables[: (size + b) * n], size + b, n)
    last = variables[(size + b) * n :]
    states, controls = stages[:size, :], stages[size:, :]
    one = interval(task)
    following = ca.horzcat(states[:, 1:], last)
    after, cost, path = one.step.map(n)(states, controls, ca.DM(stage_data(task)))
    # FATROP wants the next state with a plus sign.
    gaps = following - after
    end_cost, rows = ending(task)(last)
    start = [states[:, 0] - ca.DM(np.asarray(task.parameters.start))] if start_rows else []
    # Each stage's rows stand together: gaps, then the start's, then the inequalities.
    first = ca.vertcat(gaps[:, 0], *start, path[:, 0])
    rest = ca.vertcat(gaps[:, 1:], path[:, 1:])
    return {
        "x": variables,
        "f": ca.sum2(cost) + end_cost,
        "g": ca.veccat(first, rest, rows),
    }


def bounds(task: WheelsTask, start_rows: bool) -> dict[str, Floats]:
    """Bounds of the variables and rows of `program`."""
    n, form = task.manoeuvre.intervals, task.form
    size = 10 if form.torqued else 7
    free, one = np.full(size, np.inf), np.ones(form.wheels)
    high = np.full(form.powers, np.inf)
    lower = np.r_[np.tile(np.r_[-free, -one, -high], n), -free]
    upper = np.r_[np.tile(np.r_[free, one, high], n), free]
    rows = 2 * form.powers
    inequality = np.r_[np.zeros(size), np.full(rows, np.inf)]
    first = np.r_[np.zeros(size * (1 + start_rows)), np.full(rows, np.inf)]
    if not start_rows:
        lower[:size] = upper[:size] = np.asarray(task.parameters.start)
    above = np.r_[first, np.tile(inequality, n - 1), np.zeros(6)]
    return {"lbx": lower, "ubx": upper, "lbg": np.zeros(len(above)), "ubg": above}


def structure(task: WheelsTask) -> dict[str, Any]:
    """Options that tell FATROP its stages."""
    n, form = task.manoeuvre.intervals, task.form
    size, rows = (10 if form.torqued else 7), 2 * form.powers
    first = [True] * (2 * size) + [False] * rows
    later = [True] * size + [False] * rows
    return {
        "structure_detection": "manual",
        "N": n,
        "nx": [size] * (n + 1),
        "nu": [form.controls] * n + [0],
        "ng": [size + rows] + [rows] * (n - 1) + [6],
        "equality": first + later * (n - 1) + [True] * 6,
    }


@dataclass(frozen=True, eq=False)
class Ended:
    """How a start ended: wheel torques (N, n) [N m], the solver's word, passes and CPU time [s].

    cost : [J], with the sign of a cost.
    """

    torque: Floats
    status: str
    iterations: int
    cpu_s: float
    cost: float


class Solver:
    """The manoeuvre of a task with one method, "ipopt" or "fatrop", compiled into a folder."""

    def __init__(
        self, task: WheelsTask, method: str, folder: Path, options: dict[str, Any] | None = None
    ) -> None:
        """Build and compile."""
        self.task, self.method = task, method
        rows = method == "fatrop"
        settings: dict[str, Any] = dict(IPOPT if options is None else options)
        if rows:
            settings = {**structure(task), "fatrop": FATROP if options is None else options}
        self.function = compiled_solver(method, program(task, rows), settings, folder)
        self.limits = bounds(task, rows)

    def __call__(self, u: Floats, x: Floats) -> Ended:
        """Solve from controls (N, b) and states (N + 1, s) of the package's programme."""
        guess = np.r_[np.concatenate([x[:-1], u], axis=1).ravel(), x[-1]]
        began = time.process_time()
        answer = self.function(x0=guess, **self.limits)
        spent = time.process_time() - began
        n, size, form = len(u), x.shape[1], self.task.form
        stages = np.asarray(answer["x"]).ravel()[:-size].reshape(n, -1)
        stats = self.function.stats()
        return Ended(
            stages[:, size : size + form.wheels] * np.asarray(self.task.parameters.torque_limit),
            str(
                stats["return_status"] if self.method == "ipopt" else stats["unified_return_status"]
            ),
            int(stats["iter_count"]),
            spent,
            float(answer["f"]) * float(self.task.parameters.energy_scale),
        )
