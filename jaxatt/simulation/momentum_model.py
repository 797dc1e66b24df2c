"""Roll-out of a rigid body with reaction wheels in terms of the total angular momentum.

The wheel speeds follow from the total angular momentum, which the wheels cannot change: in
inertial axes it stays as it is unless an external torque acts.  What is left is the attitude and
the rate relative to inertial, seven states, and three more only where there are such torques.  The
orbit enters through the target, which is turned to inertial axes, and through those torques.

The state is a tuple of scalars and the right-hand side is written in components on purpose: under
`jax.vmap` with the batch axis last every scalar becomes one contiguous batch vector, and the scan
over the four Runge-Kutta stages keeps XLA from recomputing the straight-line code, which together
are several times faster on a CPU than the same equations with small matrices.  For the same reason
the nodes leave the loop as one array.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.environment.table import Environment, EnvironmentTable

Components = tuple[Array, ...]

_NEXT_POINT = (0.5, 0.5, 1.0, 0.0)
_WEIGHT = (1 / 6, 1 / 3, 1 / 3, 1 / 6)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class BodyParameters:
    """Inertia of the vehicle, as the momentum model needs it.

    inertia : (3, 3) [kg m^2], total inertia J with wheels.
    inverse_inertia : (3, 3) [1/(kg m^2)], inverse of J_s, the inertia without wheel spin.
    """

    inertia: Array
    inverse_inertia: Array


def cross(a: Components, b: Components) -> Components:
    """Vector product a x b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def matvec(matrix: Array, v: Components) -> Components:
    """Product of a (3, 3) matrix and a vector."""
    return tuple(matrix[i, 0] * v[0] + matrix[i, 1] * v[1] + matrix[i, 2] * v[2] for i in range(3))


def to_body(q: Components, v: Components) -> Components:
    """Turn a vector from inertial to body components: R(q_ib)' v."""
    once = cross(q[1:4], v)
    twice = cross(q[1:4], once)
    return tuple(v[i] - 2.0 * (q[0] * once[i] - twice[i]) for i in range(3))


def to_inertial(q: Components, v: Components) -> Components:
    """Turn a vector from body to inertial components: R(q_ib) v."""
    return to_body((-q[0], *q[1:4]), v)


def _down(q_io: Array) -> Array:
    """Unit vector to the Earth's centre in inertial axes, (..., 3), of q_io (..., 4)."""
    w, x, y, z = (q_io[..., i] for i in range(4))
    return jnp.stack(
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1
    )


def derivative(
    state: Components,
    torque: Components,
    momentum: Components,
    environment: Environment,
    body: BodyParameters,
    disturbed: bool,
) -> Components:
    """Time derivative of the states of the momentum model.

    state : q_ib (4), omega_ib (3) [rad/s] in body axes and, if disturbed, the total momentum (3)
        [N m s] in inertial axes.
    torque : three scalars [N m], torque on the wheels in body axes; the body receives its negative.
    momentum : the total momentum where it is constant; not read if disturbed.
    environment : at this instant, with `down` in place of the orbit's attitude.
    disturbed : whether its external torques act (static).
    Source: Schaanning (2021), eqs. (4.2), (4.9), (4.11), (4.20b), in inertial axes.
    """
    q, w = state[:4], state[4:7]
    turning = cross(to_body(q, state[7:] if disturbed else momentum), w)
    if not disturbed:
        return turning_rate(q, w) + matvec(
            body.inverse_inertia, tuple(turning[i] - torque[i] for i in range(3))
        )
    external = tidal_torque(q, environment, body)
    omega_rate = matvec(
        body.inverse_inertia, tuple(turning[i] + external[i] - torque[i] for i in range(3))
    )
    return turning_rate(q, w) + omega_rate + to_inertial(q, external)


def turning_rate(q: Components, w: Components) -> Components:
    """Derivative of a quaternion at a body rate w [rad/s]; Schaanning (2021), eq. (4.2)."""
    return (
        0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]),
        0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]),
        0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]),
        0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]),
    )


def tidal_torque(q: Components, environment: Environment, body: BodyParameters) -> Components:
    """Gravity gradient plus known disturbance in body axes, three scalars [N m]."""
    down_i = tuple(environment.orbit_attitude[i] for i in range(3))
    down = to_body(q, down_i)
    tidal = cross(down, matvec(body.inertia, down))
    return tuple(environment.gradient * tidal[i] + environment.disturbance[i] for i in range(3))


def with_down(stages: Environment) -> Environment:
    """Tabulated stages with the unit vector `down` in place of the orbit's attitude, for `step`."""
    return stages._replace(orbit_attitude=_down(stages.orbit_attitude))


def integrate(
    base: Components,
    rate: Callable[[Components, Environment], Components],
    along: Environment,
    h: Array,
) -> Components:
    """State after one RK4 step of h [s], with the quaternion normalised.

    along : leading axis 4, the environment at the stage times.
    """

    def stage(
        carry: tuple[Components, Components], inputs: tuple[tuple[Array, Array], Environment]
    ) -> tuple[tuple[Components, Components], None]:
        point, total = carry
        (ahead, weight), environment = inputs
        k = rate(point, environment)
        point = tuple(x + ahead * h * dx for x, dx in zip(base, k, strict=True))
        total = tuple(x + weight * h * dx for x, dx in zip(total, k, strict=True))
        return (point, total), None

    coefficients = (jnp.asarray(_NEXT_POINT), jnp.asarray(_WEIGHT))
    (_, end), _ = lax.scan(stage, (base, base), (coefficients, along))
    scale = lax.rsqrt(end[0] ** 2 + end[1] ** 2 + end[2] ** 2 + end[3] ** 2)
    return tuple(x * scale for x in end[:4]) + end[4:]


def step(
    state: Components,
    momentum: Components,
    torque: Components,
    along: Environment,
    h: Array,
    body: BodyParameters,
    disturbed: bool,
) -> Components:
    """State after one interval of constant torque.

    state : as for `derivative`.  along : leading axes (S, 4), the stages of S substeps of h [s],
    from `with_down`.  The quaternion is normalised after every substep.
    """

    def substep(base: Components, environment: Environment) -> Components:
        return integrate(
            base, lambda x, at: derivative(x, torque, momentum, at, body, disturbed), environment, h
        )

    if along.gradient.shape[0] == 1:
        return substep(state, jax.tree.map(lambda leaf: leaf[0], along))
    end, _ = lax.scan(lambda x, environment: (substep(x, environment), None), state, along)
    return end


def rollout(
    state: Components,
    momentum: Components,
    torque: Array,
    table: EnvironmentTable,
    body: BodyParameters,
    disturbed: bool,
) -> tuple[Components, Array]:
    """Simulate a piecewise constant torque with fixed-step RK4.

    state : seven scalars at the first node, q_ib and omega_ib [rad/s].
    momentum : three scalars [N m s], total momentum in inertial axes at the first node.
    torque : (N, 3) [N m], torque on the wheels in body axes, constant over each interval.
    table : environment at the stage times of every substep; its shape sets N and the substeps.
    disturbed : whether the table's external torques act (static).

    Returns the state at the last node, scalars, and at nodes 1 to N, (N, n): q_ib, omega_ib and,
    where it is disturbed, the total momentum.  The quaternion is normalised after every step.
    """

    def interval(
        carry: Components, inputs: tuple[Array, Environment, Array]
    ) -> tuple[Components, Array]:
        row, along, h = inputs
        tau = (row[0], row[1], row[2])
        end = step(carry, momentum, tau, along, h, body, disturbed)
        return end, jnp.stack(end)

    first = state + momentum if disturbed else state
    h = jnp.broadcast_to(table.substep, torque.shape[:1])
    end, nodes = lax.scan(interval, first, (torque, with_down(table.stages), h))
    return end, nodes
