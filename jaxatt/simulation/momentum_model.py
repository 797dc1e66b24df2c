"""Roll-out of a rigid body with reaction wheels in its ten momentum states.

The orbit does not depend on the control, so everything that belongs to it is tabulated, and the
wheel speeds follow from the total angular momentum.  What is left is the attitude quaternion, the
inertial rate and the total momentum in body axes.

The state is a tuple of ten scalars and the right-hand side is written in components on purpose:
under `jax.vmap` every scalar becomes one contiguous batch vector, and the scan over the four
Runge-Kutta stages keeps XLA from recomputing the straight-line code, which together are several
times faster on a CPU than the same equations with small matrices.
"""

from __future__ import annotations

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
    """What the momentum model needs to know of the vehicle.

    inertia : (3, 3) [kg m^2], total inertia J with wheels.
    inverse_inertia : (3, 3) [1/(kg m^2)], inverse of J_s, the inertia without wheel spin.
    """

    inertia: Array
    inverse_inertia: Array


def _cross(a: Components, b: Components) -> Components:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _matvec(matrix: Array, v: Components) -> Components:
    return tuple(matrix[i, 0] * v[0] + matrix[i, 1] * v[1] + matrix[i, 2] * v[2] for i in range(3))


def _to_body(q: Components, v: Components) -> Components:
    """Orbit components of a vector into body components: R(q_ob)' v."""
    eta, eps = q[0], q[1:4]
    once = _cross(eps, v)
    twice = _cross(eps, once)
    return tuple(v[i] - 2.0 * (eta * once[i] - twice[i]) for i in range(3))


def relative_rate(state: Components, orbit_rate: Array) -> Components:
    """Body rate relative to the orbit frame, omega_ob = omega_ib - R' omega_io (eq. 4.3)."""
    carried = _to_body(state[:4], (orbit_rate[0], orbit_rate[1], orbit_rate[2]))
    return tuple(state[4 + i] - carried[i] for i in range(3))


def derivative(
    state: Components,
    torque: Components,
    environment: Environment,
    body: BodyParameters,
    disturbed: bool,
) -> Components:
    """Right-hand side of the momentum model.

    state : ten scalars, q_ob (4), omega_ib (3) [rad/s], total momentum H (3) [N m s], body axes.
    torque : three scalars [N m], torque on the wheels in body axes; the body receives its negative.
    environment : at this instant.  disturbed : whether its external torques act (static).
    Source: Schaanning (2021), eqs. (4.2), (4.9), (4.11), (4.20b), with omega_ob algebraic (4.3).
    """
    q, omega, momentum = state[:4], state[4:7], state[7:10]
    w = relative_rate(state, environment.orbit_rate)
    q_rate = (
        0.5 * (-q[1] * w[0] - q[2] * w[1] - q[3] * w[2]),
        0.5 * (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]),
        0.5 * (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]),
        0.5 * (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]),
    )
    momentum_rate = _cross(momentum, omega)
    if disturbed:
        down = (
            2.0 * (q[1] * q[3] - q[0] * q[2]),
            2.0 * (q[2] * q[3] + q[0] * q[1]),
            1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]),
        )
        tidal = _cross(down, _matvec(body.inertia, down))
        momentum_rate = tuple(
            momentum_rate[i] + environment.gradient * tidal[i] + environment.disturbance[i]
            for i in range(3)
        )
    omega_rate = _matvec(
        body.inverse_inertia, tuple(momentum_rate[i] - torque[i] for i in range(3))
    )
    return q_rate + omega_rate + momentum_rate


def rollout(
    state: Components,
    torque: Array,
    table: EnvironmentTable,
    body: BodyParameters,
    disturbed: bool,
) -> tuple[Components, Components]:
    """Fly a piecewise constant torque with fixed-step RK4.

    state : ten scalars at the first node (see `derivative`).
    torque : (N, 3) [N m], torque on the wheels in body axes, constant over each interval.
    table : environment at the stage times of every substep; its shape sets N and the substeps.
    disturbed : whether the table's external torques act (static).

    Returns the state at the last node and the states at nodes 1 to N (ten arrays of shape (N,)).
    The quaternion is normalised after every step.
    """
    h = table.substep
    coefficients = (jnp.asarray(_NEXT_POINT), jnp.asarray(_WEIGHT))

    def substep(base: Components, tau: Components, stages: Environment) -> Components:
        def stage(
            carry: tuple[Components, Components], inputs: tuple[tuple[Array, Array], Environment]
        ) -> tuple[tuple[Components, Components], None]:
            point, total = carry
            (ahead, weight), environment = inputs
            k = derivative(point, tau, environment, body, disturbed)
            point = tuple(x + ahead * h * dx for x, dx in zip(base, k, strict=True))
            total = tuple(x + weight * h * dx for x, dx in zip(total, k, strict=True))
            return (point, total), None

        (_, end), _ = lax.scan(stage, (base, base), (coefficients, stages))
        scale = lax.rsqrt(end[0] ** 2 + end[1] ** 2 + end[2] ** 2 + end[3] ** 2)
        return tuple(x * scale for x in end[:4]) + end[4:]

    def interval(
        carry: Components, inputs: tuple[Array, Environment]
    ) -> tuple[Components, Components]:
        row, stages = inputs
        tau = (row[0], row[1], row[2])
        if stages.gradient.shape[0] == 1:
            end = substep(carry, tau, jax.tree.map(lambda leaf: leaf[0], stages))
        else:
            end, _ = lax.scan(lambda x, env: (substep(x, tau, env), None), carry, stages)
        return end, end

    return lax.scan(interval, state, (torque, table.stages))
