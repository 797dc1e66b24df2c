"""One Runge-Kutta step of a rigid body whose wheel torques are constant over the step.

With wheel torques held, the momentum of each wheel about its axis, Jw (omega_bw + a' omega_ib),
grows linearly in time, exactly.  What is left to integrate are seven states, attitude and rate
relative to inertial; the wheel speeds follow without error of their own.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Matrix, Quaternion, Vector
from jaxatt.environment.external import Along, ExternalTorques

_NEXT_POINT = (0.5, 0.5, 1.0, 0.0)
_WEIGHT = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
_ELAPSED = (0.0, 0.5, 0.5, 1.0)


class Motion(NamedTuple):
    """Attitude q_ib, and rate omega_ib [rad/s] in body axes."""

    q_ib: Quaternion
    omega: Vector


class Body(NamedTuple):
    """Inertia of the vehicle, as the step needs it.

    inertia : [kg m^2], total, for the gravity gradient.
    without_spin : J_s.  inverse : of J_s.
    """

    inertia: Matrix
    without_spin: Matrix
    inverse: Matrix


def runge_kutta(
    start: Motion,
    wheel_momentum: Vector,
    torque: Vector,
    dipole: Vector | None,
    along: Along,
    step: Array,
    body: Body,
    torques: ExternalTorques,
) -> Motion:
    """Attitude and rate after one step.

    wheel_momentum : A h at the start [N m s], h the wheels' axial momenta, inertial.
    torque : A tau_w [N m], on the wheels; the body receives its negative.
    along : (4,), at the four stages.
    Source: Schaanning (2021), eqs. (4.2), (4.9) and (4.20b), with J omega + A Jw omega_bw written
    as J_s omega + A h.
    """

    def rate(at: Motion, elapsed: Array, environment: Along) -> Motion:
        momentum = body.without_spin @ at.omega + wheel_momentum + (elapsed * step) * torque
        external = torques.total(at.q_ib, at.omega, environment, body.inertia, dipole)
        turning = momentum.cross(at.omega) + external - torque
        return Motion(at.q_ib.derivative(at.omega), body.inverse @ turning)

    def stage(
        carry: tuple[Motion, Motion], inputs: tuple[tuple[Array, ...], Along]
    ) -> tuple[tuple[Motion, Motion], None]:
        point, total = carry
        (ahead, weight, elapsed), environment = inputs
        slope = rate(point, elapsed, environment)
        point = jax.tree.map(lambda x, dx: x + (ahead * step) * dx, start, slope)
        total = jax.tree.map(lambda x, dx: x + (weight * step) * dx, total, slope)
        return (point, total), None

    coefficients = tuple(jnp.asarray(c) for c in (_NEXT_POINT, _WEIGHT, _ELAPSED))
    (_, end), _ = lax.scan(stage, (start, start), (coefficients, along))
    return Motion(end.q_ib.normalized(), end.omega)
