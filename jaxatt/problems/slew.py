"""Slew of a spacecraft with reaction wheels, as the solver sees it.

The decision variables are scaled control torques, in body axes (mapped to the wheels by the
Moore-Penrose allocation) or directly in wheel axes.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude import quaternion
from jaxatt.environment.table import EnvironmentTable
from jaxatt.problems.hands_off import SparseSystem
from jaxatt.simulation import momentum_model
from jaxatt.simulation.momentum_model import BodyParameters

RATE_SCALE = 10.0
"""[s] A rate error of 1 rad/s counts as 10 rad: over the last ten seconds it would turn as much."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SlewParameters:
    """All numbers of a slew; every leaf may be batched, swept or differentiated.

    body : inertias.  table : environment along the orbit.
    start : (10,), q_ob, omega_ib [rad/s], total momentum [N m s] at the first node.
    reference : (4,), target q_ob; its sign selects the way round.
    reference_rate : (3,) [rad/s], target omega_ob.
    waypoint : (4,), attitude at `waypoint_node`; waypoint_node : () int, in 1 .. N.
    to_body : (3, b) [N m], body torque of a unit of the scaled controls.
    to_wheels : (n, b), wheel torques in units of their limits.
    step : () [s], length of an interval.
    wheel_speed : (n,) [rad/s] at the first node; wheel_axes : (3, n); wheel_inertia : (n,);
    wheel_torque : (n, b) [N m], wheel torques of a unit of the controls;
    speed_limit : (n,) [rad/s].
    """

    body: BodyParameters
    table: EnvironmentTable
    start: Array
    reference: Array
    reference_rate: Array
    waypoint: Array
    waypoint_node: Array
    to_body: Array
    to_wheels: Array
    step: Array
    wheel_speed: Array
    wheel_axes: Array
    wheel_inertia: Array
    wheel_torque: Array
    speed_limit: Array


@dataclass(frozen=True)
class SlewForm:
    """What is compiled in: which terms a slew has."""

    disturbed: bool = False
    has_waypoint: bool = False
    speed_limited: bool = False


def attitude_row(reference: Array, q: Array) -> Array:
    """4 sin(phi/4) about the error's axis, (3,), smooth on the whole way from 0 to 2 pi.

    Its squared norm is 8 (1 - |q' q_ref|), so the attitude cost g of (5.2) is an eighth of it.
    """
    error = quaternion.multiply(quaternion.conjugate(reference), q)
    return 2.0 * error[1:] * jnp.sqrt(2.0 / jnp.maximum(1.0 + error[0], 1e-12))


def _rollout(
    u: Array, p: SlewParameters, form: SlewForm
) -> tuple[momentum_model.Components, momentum_model.Components]:
    start = tuple(p.start[i] for i in range(10))
    return momentum_model.rollout(start, u @ p.to_body.T, p.table, p.body, form.disturbed)


def terminal_rows(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Attitude and rate errors at the last node, then the attitude error at the waypoint.

    Returns (6,) or (9,): [rad], `RATE_SCALE` x [rad/s], [rad].
    """
    end, nodes = _rollout(u, p, form)
    rate = jnp.stack(momentum_model.relative_rate(end, p.table.nodes.orbit_rate[-1]))
    rows = [
        attitude_row(p.reference, jnp.stack(end[:4])),
        RATE_SCALE * (rate - p.reference_rate),
    ]
    if form.has_waypoint:
        q = jnp.stack([node[p.waypoint_node - 1] for node in nodes[:4]])
        rows.append(attitude_row(p.waypoint, q))
    return jnp.concatenate(rows)


def wheel_speeds(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Wheel speeds at nodes 1 to N, (N, n) [rad/s].

    Integral of (4.20d): J_w (omega_bw - omega_bw(0)) is the impulse on the wheel less
    J_w A' (omega_ib - omega_ib(0)).
    """
    _, nodes = _rollout(u, p, form)
    omega = jnp.stack(nodes[4:7], axis=-1)
    impulse = jnp.cumsum(u @ p.wheel_torque.T, axis=0) * p.step
    return (
        p.wheel_speed[None]
        + impulse / p.wheel_inertia[None]
        - (omega - p.start[None, 4:7]) @ p.wheel_axes
    )


def speed_margins(u: Array, p: SlewParameters, form: SlewForm) -> Array:
    """Distance of every wheel speed to its limits, in units of the limit; (0,) without limits."""
    if not form.speed_limited:
        return jnp.zeros((0,), u.dtype)
    relative = wheel_speeds(u, p, form) / p.speed_limit[None]
    return jnp.concatenate([(1.0 - relative).ravel(), (1.0 + relative).ravel()])


def torque_margins(u: Array, p: SlewParameters) -> Array:
    """Distance of every wheel torque to its limits, in units of the limit, (N, 2 n)."""
    relative = u @ p.to_wheels.T
    return jnp.concatenate([1.0 - relative, 1.0 + relative], axis=1)


@functools.cache
def slew_system(form: SlewForm) -> SparseSystem:
    """The slew as a system for sparse control, with the terms of `form` compiled in."""
    return SparseSystem(
        rows=lambda u, p: terminal_rows(u, p, form),
        margins=lambda u, p: speed_margins(u, p, form),
        stage_margins=torque_margins,
        turned=lambda p, sign: replace(p, reference=p.reference * sign),
    )
