"""Slew of a spacecraft with reaction wheels, as functions of scaled torques.

The decision variables are scaled control torques, in body axes (mapped to the wheels by the
Moore-Penrose allocation) or directly in wheel axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.environment.table import EnvironmentTable
from jaxatt.problems.pointing.cones import PointingPath
from jaxatt.problems.pointing.spare_cones import spare_cones
from jaxatt.problems.terminal_rows import RATE_SCALE, attitude_row, attitude_rows, rolled_rate
from jaxatt.simulation import momentum_model
from jaxatt.simulation.momentum_model import BodyParameters


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SlewParameters:
    """Parameters of a slew; every leaf may be batched, swept or differentiated.

    body : inertias.  table : environment along the orbit.
    start : (7,), q_ib and omega_ib [rad/s] at the first node.
    momentum : (3,) [N m s], total momentum at the first node, in inertial axes; where thrusters
        act, in body axes.
    reference : (4,), target q_ob; its sign selects the way round.
    reference_rate : (3,) [rad/s], target omega_ob.
    held : (3, 3) or (2, 3), body axes about which the target's attitude is held.
    waypoint : (4,), attitude at `waypoint_node`; waypoint_node : () int, in 1 .. N.
    to_body : (3, b) [N m], body torque of a unit of the scaled controls.
    to_external : (3, b) [N m], body torque of thrusters of a unit of the scaled controls.
    to_wheels : (n, b), wheel torques in units of their limits.
    lower, upper : (b,), limits of the scaled controls; infinite where they have none of their own.
    step : () [s], length of an interval; or (N,), zero in what fills a programme up.
    wheel_speed : (n,) [rad/s] at the first node; wheel_axes : (3, n); wheel_inertia : (n,);
    wheel_torque : (n, b) [N m], wheel torques of a unit of the controls;
    speed_lower, speed_upper : (n,) [rad/s], range of the wheel speeds.
    pointing : cones and rate limits along the slew.
    """

    body: BodyParameters
    table: EnvironmentTable
    start: Array
    momentum: Array
    reference: Array
    reference_rate: Array
    held: Array
    waypoint: Array
    waypoint_node: Array
    to_body: Array
    to_external: Array
    to_wheels: Array
    lower: Array
    upper: Array
    step: Array
    wheel_speed: Array
    wheel_axes: Array
    wheel_inertia: Array
    wheel_torque: Array
    speed_lower: Array
    speed_upper: Array
    pointing: PointingPath


@dataclass(frozen=True)
class SlewForm:
    """Terms that a slew has, which are compiled in.

    gyroscopic : whether the total momentum is so large that `pulse_equations` does not hold.
    has_thrusters : whether thrusters act, which change the total momentum.
    pointed : whether cones or rate limits are enforced.
    """

    disturbed: bool = False
    has_waypoint: bool = False
    speed_limited: bool = False
    gyroscopic: bool = False
    has_thrusters: bool = False
    pointed: bool = False

    @property
    def path_limited(self) -> bool:
        """Whether there are path constraints besides limits of the controls."""
        return self.speed_limited or self.pointed

    def spare_cones(self, count: int) -> int:
        """How many cones are added to so many: only with wheels, whose programs share them."""
        return 0 if self.has_thrusters else spare_cones(count)


def body_torque(u: Array, p: SlewParameters) -> Array:
    """Torque on the wheels in body axes from scaled controls, (N, 3) [N m]."""
    # Not a product of matrices: elementwise, the batch axis stays where `vmap` has put it.
    torque = u[:, :1] * p.to_body[None, :, 0]
    for c in range(1, u.shape[1]):
        torque = torque + u[:, c, None] * p.to_body[None, :, c]
    return torque


def fly_nodes(
    u: Array, p: SlewParameters, form: SlewForm
) -> tuple[momentum_model.Components, Array]:
    """Roll-out of scaled controls: last state, and states at nodes 1 to N; see `rollout`."""
    start = tuple(p.start[i] for i in range(7))
    momentum = tuple(p.momentum[i] for i in range(3))
    torque = body_torque(u, p)
    return momentum_model.rollout(start, momentum, torque, p.table, p.body, form.disturbed)


def inertial_reference(p: SlewParameters) -> Array:
    """Target q_ib at the last node, (4,); its sign selects the way round."""
    return quaternion.multiply(p.table.nodes.orbit_attitude[-1], p.reference)


def inertial_waypoint(p: SlewParameters) -> Array:
    """Waypoint's q_ib at its node, (4,)."""
    return quaternion.multiply(p.table.nodes.orbit_attitude[p.waypoint_node], p.waypoint)


def rate_row(q_ib: Array, omega_ib: Array, p: SlewParameters) -> Array:
    """Scaled error of the rate relative to the orbit frame at the last node, (3,)."""
    nodes = p.table.nodes
    orbit_rate_i = quaternion.rotate(nodes.orbit_attitude[-1], nodes.orbit_rate[-1])
    relative = omega_ib - quaternion.rotate_inverse(q_ib, orbit_rate_i)
    wanted = rolled_rate(inertial_reference(p), p.reference_rate, q_ib, p.held)
    return RATE_SCALE * (relative - wanted)


def terminal_rows(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Errors of attitude and rate at the last node, then of attitude at the waypoint.

    Returns (6,) or (9,), one less where the roll is free: [rad], `RATE_SCALE` x [rad/s], [rad].
    """
    end, nodes = fly_nodes(u, p, form)
    q = jnp.stack(end[:4])
    missed = attitude_rows(inertial_reference(p), q, p.held)
    rows = [missed, rate_row(q, jnp.stack(end[4:7]), p)]
    if form.has_waypoint:
        rows.append(attitude_row(inertial_waypoint(p), nodes[p.waypoint_node - 1, :4]))
    return jnp.concatenate(rows)


def wheel_speeds(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Wheel speeds at nodes 1 to N, (N, n) [rad/s].

    Integral of (4.20d): J_w (omega_bw - omega_bw(0)) is the impulse on the wheel less
    J_w A' (omega_ib - omega_ib(0)).
    """
    omega = fly_nodes(u, p, form)[1][:, 4:7]
    impulse = jnp.cumsum(u @ p.wheel_torque.T, axis=0) * p.step
    return (
        p.wheel_speed[None]
        + impulse / p.wheel_inertia[None]
        - (omega - p.start[None, 4:]) @ p.wheel_axes
    )


def speed_margins(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Distance of every wheel speed to its limits, in units of the limit; (0,) without limits."""
    if not form.speed_limited:
        return jnp.zeros((0,), u.dtype)
    return jnp.concatenate([side.ravel() for side in range_margins(wheel_speeds(u, p, form), p)])


def range_margins(speeds: Array, p: SlewParameters) -> tuple[Array, Array]:
    """Distances of wheel speeds (..., n) [rad/s] to the upper and the lower end of their range.

    In units of the speed there; 1 where there is no end.
    """
    shape = (1,) * (speeds.ndim - 1) + p.speed_upper.shape
    upper, lower = p.speed_upper.reshape(shape), p.speed_lower.reshape(shape)
    return (
        jnp.sign(upper) - speeds / jnp.abs(upper),
        speeds / jnp.abs(lower) - jnp.sign(lower),
    )


def bound_margins(u: Array, p: SlewParameters) -> Array:
    """Distance of every scaled control to its own limits, (N, 2 b)."""
    return jnp.concatenate([p.upper[None] - u, u - p.lower[None]], axis=1)


def torque_margins(u: Array, p: SlewParameters) -> Array:
    """Distance of every wheel torque to its limits, in units of the limit, (N, 2 n)."""
    relative = u @ p.to_wheels.T
    return jnp.concatenate([1.0 - relative, 1.0 + relative], axis=1)
