"""Wheel speeds that store no momentum and torques that do not turn the body.

With more than three wheels, momenta h of the wheels with A h = 0 cancel in the body: a bias that
keeps wheels away from standstill, or apart from one another.
"""

from __future__ import annotations

import numpy as np

from jaxatt.spacecraft.checks import Float64
from jaxatt.spacecraft.parts.wheels import ReactionWheels


def null_momenta(wheels: ReactionWheels) -> Float64:
    """Return an orthonormal basis of wheel momenta, or torques, that cancel, (n, n - 3)."""
    basis: Float64 = np.linalg.svd(np.asarray(wheels.axes))[2][3:].T
    return basis


def bias_of(wheels: ReactionWheels, omega_bw: Float64) -> Float64:
    """Return the part of wheel speeds (n,) [rad/s] that stores no momentum.

    The momenta of the rest, J_w times the speeds, are those of least norm with the same sum.
    """
    basis, inertia = null_momenta(wheels), np.asarray(wheels.inertia)
    return np.asarray(basis @ (basis.T @ (inertia * omega_bw)) / inertia)


def unit_bias(wheels: ReactionWheels) -> Float64:
    """Return the bias of unit norm of n = 4 wheels, (4,); its first entry that counts is positive.

    Without a wheel that fails it is the only one but for its size.
    """
    speeds = null_momenta(wheels)[:, 0] / np.asarray(wheels.inertia)
    first = speeds[np.abs(speeds) > 1e-9 * np.abs(speeds).max()][0]
    return np.asarray(speeds * np.sign(first) / np.linalg.norm(speeds))
