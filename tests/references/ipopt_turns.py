"""Turns of a body with wheels by CasADi and IPOPT, written out from the equations of motion.

Without external torques the total momentum stays where it is in the inertial frame, which here is
the one that the body's axes have at the start.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

OPTIONS = {"ipopt.tol": 1e-10, "ipopt.print_level": 0, "print_time": False, "expand": True}


@dataclass
class Turn:
    """From rate `begin` to attitude `target` (scalar first) and rate `end`, wheels still at first.

    axes : (3, n).  limit : [N m].  inertia, without_spin : (3, 3), with and without the wheels'
    inertia about their axes.  null_impulse : (n,) [N m s], of the wheels in the null space of the
    axes until the end; None for any.
    """

    axes: np.ndarray
    limit: float
    inertia: np.ndarray
    without_spin: np.ndarray
    target: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    intervals: int
    null_impulse: np.ndarray | None = None

    def step(self):
        """(state, wheel torques, h) -> next state by RK4; state is quaternion and rate."""
        x, u, h = ca.SX.sym("x", 7), ca.SX.sym("u", self.axes.shape[1]), ca.SX.sym("h")
        inverse = ca.DM(np.linalg.inv(self.without_spin))
        total = ca.DM(self.inertia @ self.begin)

        def slope(x):
            q, w = x[:4], x[4:]
            turning = 0.5 * ca.vertcat(-ca.dot(q[1:], w), q[0] * w + ca.cross(q[1:], w))
            twice = 2.0 * ca.cross(-q[1:], total)
            momentum = total + q[0] * twice + ca.cross(-q[1:], twice)
            push = -ca.cross(w, momentum) - ca.DM(self.axes) @ u
            return ca.vertcat(turning, inverse @ push)

        k1 = slope(x)
        k2 = slope(x + h / 2 * k1)
        k3 = slope(x + h / 2 * k2)
        k4 = slope(x + h * k3)
        return ca.Function("step", [x, u, h], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])

    def constrain(self, opti, wheels, h):
        """Multiple shooting, started along the eigenaxis."""
        n, target, advance = self.intervals, self.target, self.step()
        x = opti.variable(7, n + 1)
        opti.subject_to(x[:, 0] == ca.DM(np.r_[1.0, 0.0, 0.0, 0.0, self.begin]))
        for k in range(n):
            opti.subject_to(x[:, k + 1] == advance(x[:, k], wheels[:, k], h))
        q = x[:4, n]
        missed = target[0] * q[1:] - q[0] * target[1:] - ca.cross(ca.DM(target[1:]), q[1:])
        opti.subject_to(missed == 0)
        opti.subject_to(x[4:, n] == ca.DM(self.end))
        opti.subject_to(opti.bounded(-self.limit, ca.vec(wheels), self.limit))
        if self.null_impulse is not None:
            basis = ca.DM(np.linalg.svd(self.axes)[2][3:])
            opti.subject_to(basis @ (h * ca.sum2(wheels) - ca.DM(self.null_impulse)) == 0)
        half = np.arccos(np.clip(target[0], -1.0, 1.0)) * np.linspace(0.0, 1.0, n + 1)
        axis = target[1:] / np.linalg.norm(target[1:])
        opti.set_initial(x[:4, :], np.vstack([np.cos(half), np.outer(axis, np.sin(half))]))


def least_cost(turn, rho, time):
    """Least final time plus rho times the squared effort, and the time itself; time : a guess."""
    opti = ca.Opti()
    u, h = opti.variable(turn.axes.shape[1], turn.intervals), opti.variable()
    turn.constrain(opti, u, h)
    opti.subject_to(h >= 0.01 * time / turn.intervals)
    opti.set_initial(h, time / turn.intervals)
    cost = turn.intervals * h + rho * h * ca.sumsqr(u)
    opti.minimize(cost)
    opti.solver("ipopt", OPTIONS)
    found = opti.solve()
    return float(found.value(cost)), turn.intervals * float(found.value(h))


def least_effort(turn, h, support):
    """Least L1 effort about the body axes with torque in the intervals of a support only.

    The wheels share a body torque by the pseudo-inverse.
    """
    opti = ca.Opti()
    unit = turn.limit
    size, signed = opti.variable(3, len(support)), opti.variable(3, len(support))
    body = ca.MX.zeros(3, turn.intervals)
    for column, k in enumerate(support):
        body[:, k] = unit * signed[:, column]
    opti.subject_to(ca.vec(size - signed) >= 0)
    opti.subject_to(ca.vec(size + signed) >= 0)
    turn.constrain(opti, ca.DM(np.linalg.pinv(turn.axes)) @ body, h)
    opti.minimize(ca.sum1(ca.vec(size)))
    opti.solver("ipopt", OPTIONS)
    return unit * h * float(opti.solve().value(opti.f))
