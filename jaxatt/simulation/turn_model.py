"""Cheap model for searching: each interval of a body with little momentum is one rotation.

An impulse in body axes and the mean rate of the interval decide it: the attitude turns about the
mean rate by its exact angle, the gyroscopic torque enters to second order in the interval.  No
external torque acts.  `momentum_model` is what the answers are flown with.
"""

from __future__ import annotations

from jax import Array

from jaxatt.simulation.momentum_model import Components, cross, matvec, to_body


def turn(
    state: Components, momentum: Components, impulse: Components, h: Array, inverse_inertia: Array
) -> Components:
    """State after one interval of the model.

    state : q_ib (4), omega_ib (3) [rad/s].  momentum : (3) [N m s], total, in inertial axes.
    impulse : (3) [rad/s], change of the rate by the control torque.  h : () [s].
    """
    q, w = state[:4], state[4:7]
    mean = tuple(a + 0.5 * b for a, b in zip(w, impulse, strict=True))
    drift = matvec(inverse_inertia, cross(to_body(q, momentum), mean))
    half = tuple(0.5 * h * (a + 0.5 * h * b) for a, b in zip(mean, drift, strict=True))
    squared = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
    # sin(x) / x and cos(x) to the eighth order in x, half the angle of an interval.
    sine = 1.0 + squared * (-1 / 6 + squared * (1 / 120 - squared / 5040))
    c = 1.0 + squared * (-1 / 2 + squared * (1 / 24 - squared / 720))
    x, y, z = (sine * k for k in half)
    turned = (
        q[0] * c - q[1] * x - q[2] * y - q[3] * z,
        q[1] * c + q[0] * x + q[2] * z - q[3] * y,
        q[2] * c + q[0] * y + q[3] * x - q[1] * z,
        q[3] * c + q[0] * z + q[1] * y - q[2] * x,
    )
    return turned + tuple(a + b + h * d for a, b, d in zip(w, impulse, drift, strict=True))
