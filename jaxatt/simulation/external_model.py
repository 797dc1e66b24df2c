"""Roll-out of a rigid body with thrusters, with the total momentum in body axes as a state.

Thrusters change the total momentum, so it is carried along, in body axes: h' = h x w + t with the
external torque t, and J_s w' = h' less the torque on the wheels.  Ten states, one cross product.
Written in components for the same reasons as `momentum_model`.

Source: Kristiansen and Gravdahl (2023), eqs. (8b) and (8c), whose left side lacks its dot; wheels
as in Schaanning (2021), eq. (4.9).
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.environment.table import Environment, EnvironmentTable
from jaxatt.simulation.momentum_model import (
    BodyParameters,
    Components,
    cross,
    integrate,
    matvec,
    tidal_torque,
    turning_rate,
    with_down,
)


def derivative(
    state: Components,
    torque: Components,
    environment: Environment,
    body: BodyParameters,
    disturbed: bool,
) -> Components:
    """Time derivative of the ten states.

    state : q_ib (4), omega_ib (3) [rad/s] and the total momentum (3) [N m s], both in body axes.
    torque : six scalars [N m] in body axes, torque on the wheels, then torque of the thrusters.
    environment : at this instant, with `down` in place of the orbit's attitude.
    disturbed : whether its external torques act (static).
    """
    q, w, h = state[:4], state[4:7], state[7:]
    external = torque[3:]
    if disturbed:
        known = tidal_torque(q, environment, body)
        external = tuple(t + k for t, k in zip(external, known, strict=True))
    change = tuple(c + t for c, t in zip(cross(h, w), external, strict=True))
    left = tuple(c - t for c, t in zip(change, torque[:3], strict=True))
    return turning_rate(q, w) + matvec(body.inverse_inertia, left) + change


def rollout(
    start: Components,
    torque: Array,
    table: EnvironmentTable,
    body: BodyParameters,
    disturbed: bool,
) -> tuple[Components, Array]:
    """Simulate piecewise constant torques with fixed-step RK4.

    start : ten scalars, see `derivative`.  torque : (N, 6) [N m], on the wheels, then of the
    thrusters, in body axes.  Returns the state at the last node, ten scalars, and at nodes 1 to N,
    (N, 10).  The quaternion is normalised after every step.
    """

    def interval(carry: Components, inputs: tuple[Array, Environment]) -> tuple[Components, Array]:
        row, along = inputs
        tau = tuple(row[i] for i in range(6))

        def rate(point: Components, environment: Environment) -> Components:
            return derivative(point, tau, environment, body, disturbed)

        def substep(base: Components, stages: Environment) -> tuple[Components, None]:
            return integrate(base, rate, stages, table.substep), None

        if along.gradient.shape[0] == 1:
            end, _ = substep(carry, jax.tree.map(lambda leaf: leaf[0], along))
        else:
            end, _ = lax.scan(substep, carry, along)
        return end, jnp.stack(end)

    end, nodes = lax.scan(interval, start, (torque, with_down(table.stages)))
    return end, nodes
