"""The slew in seven states, in an inertial frame: attitude and rate, with conserved total momentum.

Without external torques the total momentum is constant in the inertial frame, and seen from there
the orbit enters through the target alone.  This is the smallest and cheapest form of the problem,
which is what a comparison with another solver asks for.

All numbers come from a task of the package, so that both sides fly the same spacecraft.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import casadi as ca
import numpy as np
import numpy.typing as npt

from jaxatt.environment.table import EnvironmentTable
from jaxatt.problems.hands_off.slew.task import SlewTask
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.spacecraft.vehicle import total_momentum

Floats = npt.NDArray[np.float64]

RATE_UNIT = 0.1
"""[rad/s] of a unit of the scaled rate; a full pulse changes the rate by about so much."""


@dataclass(frozen=True, eq=False)
class SlewNumbers:
    """Everything the seven-state model needs, on the host.

    The controls v (3,) are the torques of three independent wheels in units of their limits, so
    that their limits are bounds; the other wheels follow through the Moore-Penrose allocation.

    inverse_inertia : (3, 3) [1/(kg m^2)], inverse of J_s, the inertia without wheel spin.
    momentum : (3,) [N m s], total momentum in the inertial frame.
    start, target : (4,) q_ib, and start_rate, target_rate : (3,) [rad/s] omega_ib, at both ends;
    the inertial frame is the orbit frame at the first node.
    orbit : (N + 1, 4), attitude q_io of the orbit frame at the nodes.
    to_body : (3, 3) [N m], torque on the wheels in body axes of a unit of the controls.
    other_wheels : (n - 3, 3), torques of the other wheels in units of their limits.
    weight : (N,).  step : [s].  epsilon : [N m], relaxation of the complementarity.
    """

    inverse_inertia: Floats
    momentum: Floats
    start: Floats
    start_rate: Floats
    target: Floats
    target_rate: Floats
    orbit: Floats
    to_body: Floats
    other_wheels: Floats
    weight: Floats
    step: float
    epsilon: float

    @property
    def intervals(self) -> int:
        """Number of control intervals N."""
        return len(self.weight)


def multiply(a: Floats, b: Floats) -> Floats:
    """Quaternion product of (4,) or (4, n) with the same, scalar first."""
    return np.array(
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] + a[2] * b[0] + a[3] * b[1] - a[1] * b[3],
            a[0] * b[3] + a[3] * b[0] + a[1] * b[2] - a[2] * b[1],
        ]
    )


def rotation(q: Floats) -> Floats:
    """Rotation matrices (3, 3) or (3, 3, n) of unit quaternions (4,) or (4, n), body to outside."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def orbit_attitude(table: EnvironmentTable, intervals: int) -> Floats:
    """Attitude q_io of the orbit frame at nodes 0 to N against that at node 0, (N + 1, 4).

    table : environment at the stage times of fine Runge-Kutta steps, in orbit axes.
    """
    rates, h = np.asarray(table.stages.orbit_rate), float(table.substep)
    q = np.array([1.0, 0.0, 0.0, 0.0])
    nodes = [q]
    for interval in range(intervals):
        for stage in rates[interval]:
            k1 = 0.5 * multiply(q, np.r_[0.0, stage[0]])
            k2 = 0.5 * multiply(q + h / 2 * k1, np.r_[0.0, stage[1]])
            k3 = 0.5 * multiply(q + h / 2 * k2, np.r_[0.0, stage[2]])
            k4 = 0.5 * multiply(q + h * k3, np.r_[0.0, stage[3]])
            q = q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            q = q / np.linalg.norm(q)
        nodes.append(q)
    return np.array(nodes)


def numbers_of(task: SparseTask) -> SlewNumbers:
    """Numbers of a slew in body axes without external torques, waypoints and speed limits.

    Raises ValueError for a slew that has them.
    """
    if not isinstance(task, SlewTask):
        raise ValueError("not a slew")
    table, craft, begin = task.table, task.craft, task.start
    disturbed = np.any(table.stages.gradient) or np.any(table.stages.disturbance)
    if disturbed or task.waypoint is not None or task.has_speed_limits or task.axes != "body":
        raise ValueError(
            "the seven-state model has no disturbances, waypoints, speed limits or wheel axes"
        )
    wheels, start = craft.wheels, np.asarray(begin.q_ob)
    relative = np.asarray(wheels.allocation) / np.asarray(wheels.torque_limit)[:, None]
    chosen = max(
        itertools.combinations(range(len(relative)), 3),
        key=lambda rows: abs(np.linalg.det(relative[list(rows)])),
    )
    to_body = np.linalg.inv(relative[list(chosen)])
    orbit = orbit_attitude(table, task.intervals)
    reference = np.asarray(task.target.q_ob)
    carried = rotation(reference).T @ np.asarray(table.nodes.orbit_rate[task.intervals])
    momentum = total_momentum(craft, begin.omega_ib, begin.omega_bw)
    return SlewNumbers(
        inverse_inertia=np.linalg.inv(np.asarray(craft.inertia_without_spin)),
        momentum=rotation(start) @ np.asarray(momentum),
        start=start,
        start_rate=np.asarray(begin.omega_ib),
        target=multiply(orbit[-1], reference),
        target_rate=carried + np.asarray(task.target.omega_ob),
        orbit=orbit,
        to_body=to_body,
        other_wheels=np.delete(relative, chosen, axis=0) @ to_body,
        weight=np.asarray(task.arguments.weight),
        step=task.step,
        epsilon=task.goal.epsilon,
    )


def step_function(numbers: SlewNumbers) -> ca.Function:
    """One classical Runge-Kutta step over an interval, (x, v) -> x.

    x : (7,), q_ib and omega_ib in units of `RATE_UNIT`.  v : (3,), controls; they are torques on
    the wheels, so the body receives their negative.
    """
    x, v = ca.SX.sym("x", 7), ca.SX.sym("v", 3)
    acceleration = ca.mtimes(ca.DM(numbers.inverse_inertia @ numbers.to_body), v)
    inverse, momentum = ca.DM(numbers.inverse_inertia), ca.DM(numbers.momentum)

    def rate(point: ca.SX) -> ca.SX:
        eta, eps, w = point[0], point[1:4], point[4:7] * RATE_UNIT
        once = ca.cross(eps, momentum)
        body = momentum - 2.0 * (eta * once - ca.cross(eps, once))
        w_rate = ca.mtimes(inverse, ca.cross(body, w)) - acceleration
        return ca.vertcat(
            -0.5 * ca.dot(eps, w), 0.5 * (eta * w + ca.cross(eps, w)), w_rate / RATE_UNIT
        )

    h = numbers.step
    k1 = rate(x)
    k2 = rate(x + h / 2 * k1)
    k3 = rate(x + h / 2 * k2)
    k4 = rate(x + h * k3)
    return ca.Function("step", [x, v], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])


def start_state(numbers: SlewNumbers) -> Floats:
    """Scaled state (7,) at the first node."""
    return np.concatenate([numbers.start, numbers.start_rate / RATE_UNIT])


def terminal_rows(numbers: SlewNumbers, end: ca.SX) -> ca.SX:
    """Attitude error (vector part) and scaled rate error at the last node, (6,).

    Both signs of the quaternion are the same attitude, so both ways round are allowed.
    """
    r = numbers.target
    q0, q = end[0], end[1:4]
    error = r[0] * q - ca.DM(r[1:]) * q0 - ca.cross(ca.DM(r[1:]), q)
    return ca.vertcat(error, end[4:7] - numbers.target_rate / RATE_UNIT)
