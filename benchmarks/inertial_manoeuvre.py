"""A manoeuvre in seven states in an inertial frame, as the other side and the judge see it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.casadi_model import numbers_of
from jaxatt.attitude import host_turns
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.time_optimal.task import ReorientationTask
from jaxatt.runtime.arrays import Floats


@dataclass(frozen=True, eq=False)
class InertialManoeuvre:
    """Attitude and rate at both ends, with conserved total momentum.

    inverse_inertia : (3, 3) [1/(kg m^2)], of the vehicle without the spin of its wheels.
    momentum : (3,) [N m s], total, in the inertial frame.
    start, target : (4,), q_ib.  start_rate, target_rate : (3,) [rad/s], omega_ib.
    to_body : (3, b) [N m], torque on the wheels in body axes of a unit of the controls, which are
        within -1 and 1.
    others : (r, b), rows l of further limits |l u| <= 1.
    """

    inverse_inertia: Floats
    momentum: Floats
    start: Floats
    start_rate: Floats
    target: Floats
    target_rate: Floats
    to_body: Floats
    others: Floats

    @property
    def weakest(self) -> float:
        """Least angular acceleration [rad/s^2] about any axis, about."""
        return float(np.linalg.svd(self.inverse_inertia @ self.to_body, compute_uv=False)[-1])

    def acceleration(self, q: Floats, rate: Floats, u: Floats) -> Floats:
        """Angular acceleration (S, 3) [rad/s^2] at q (S, 4), rate (S, 3) under controls (S, b)."""
        inside = host_turns.to_body(q, np.broadcast_to(self.momentum, rate.shape))
        return np.asarray((np.cross(inside, rate) - u @ self.to_body.T) @ self.inverse_inertia)

    def slope(self, x: Floats, u: Floats) -> Floats:
        """Time derivative (S, 7) of attitudes and rates (S, 7)."""
        q, rate = x[:, :4], x[:, 4:]
        turning = np.concatenate([np.zeros((len(x), 1)), rate], axis=1)
        return np.concatenate(
            [0.5 * host_turns.product(q, turning), self.acceleration(q, rate, u)], axis=1
        )

    def after(self, x: Floats, u: Floats, step: Floats, substeps: int) -> Floats:
        """States (S, 7) after controls (S, b) held for `step` (S, 1) [s], by Runge-Kutta steps."""
        h = step / substeps
        for _ in range(substeps):
            k1 = self.slope(x, u)
            k2 = self.slope(x + h / 2 * k1, u)
            k3 = self.slope(x + h / 2 * k2, u)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + self.slope(x + h * k3, u))
            x[:, :4] /= np.linalg.norm(x[:, :4], axis=1, keepdims=True)
        return x

    def errors(self, x: Floats) -> tuple[Floats, Floats]:
        """Errors (S,) of attitude [rad] and rate [rad/s] of states (S, 7) against the target."""
        relative = host_turns.product(host_turns.conjugate(self.target), x[:, :4])
        sine, cosine = np.linalg.norm(relative[:, 1:], axis=1), np.abs(relative[:, 0])
        return 2.0 * np.arctan2(sine, cosine), np.linalg.norm(x[:, 4:] - self.target_rate, axis=1)

    def flown_errors(self, u: Floats, step: float) -> tuple[float, float]:
        """Errors at the end of controls (N, b) held for `step` [s] each, under error control."""
        x = np.concatenate([self.start, self.start_rate])
        for held in np.asarray(u):

            def slope(_: float, x: Floats, held: Floats = held) -> Floats:
                return self.slope(x[None], held[None])[0]

            ended = solve_ivp(slope, (0.0, step), x, method="DOP853", rtol=1e-9, atol=1e-10)
            x = ended.y[:, -1]
        angle, rate = self.errors(x[None])
        return float(angle[0]), float(rate[0])


def of_slew(task: SlewTask) -> InertialManoeuvre:
    """A slew without disturbances; its controls are the torques of three independent wheels."""
    n = numbers_of(task)
    return InertialManoeuvre(
        n.inverse_inertia,
        n.momentum,
        n.start,
        n.start_rate,
        n.target,
        n.target_rate,
        n.to_body,
        n.other_wheels,
    )


def of_turn(task: ReorientationTask) -> InertialManoeuvre:
    """A turn in free time; its controls are the torques of all wheels."""
    start = np.asarray(task.start.q_ob)
    return InertialManoeuvre(
        np.linalg.inv(np.asarray(task.craft.inertia_without_spin)),
        host_turns.to_body(host_turns.conjugate(start), task.momentum),
        start,
        np.asarray(task.start.omega_ib),
        np.asarray(task.target.q_ob),
        np.asarray(task.target.omega_ob),
        task.actuation.to_body,
        np.zeros((0, task.actuation.size)),
    )
