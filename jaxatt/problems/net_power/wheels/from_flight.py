"""States of the programme from a flight, and its controls from torques, in NumPy."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.host import rotated
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.runtime.arrays import Floats

INSIDE = 0.999
"""Share of the torque limits that a start uses at most."""


def stored_of(p: WheelsParameters, form: WheelsForm, omega: Floats, speeds: Floats) -> Floats:
    """Coordinates (..., k) of the wheels' momentum; omega (..., 3), speeds (..., n) [rad/s]."""
    axes, inertia = np.asarray(p.axes), np.asarray(p.wheel_inertia)
    axial = inertia * (speeds + omega @ axes)
    if form.each:
        each: Floats = axial / float(p.momentum_scale)
        return each
    summed: Floats = axial @ axes.T @ np.asarray(p.inverse).T
    return summed


def states_of(
    p: WheelsParameters, form: WheelsForm, q: Floats, omega: Floats, speeds: Floats
) -> Floats:
    """States (..., s) without the charge, of q_ib (..., 4), omega_ib and omega_bw [rad/s]."""
    parts = [q, stored_of(p, form, omega, speeds)]
    if form.torqued:
        spun = speeds * np.asarray(p.wheel_inertia) @ np.asarray(p.axes).T
        momentum = omega @ np.asarray(p.inertia).T + spun
        parts.append(rotated(q, momentum) / float(p.momentum_scale))
    return np.concatenate(parts, axis=-1)


def dipoles_of(p: WheelsParameters, dipole: Floats) -> Floats:
    """Positive and negative parts (..., 6) of dipoles (..., 3) [A m^2], over their limits."""
    shares = np.clip(dipole / np.asarray(p.dipole_limit), -INSIDE, INSIDE)
    return np.concatenate([np.maximum(shares, 0.0), np.maximum(-shares, 0.0)], axis=-1)
