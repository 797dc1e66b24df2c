"""States and starts of the programme from a flight, in NumPy."""

from __future__ import annotations

import numpy as np

from jaxatt.problems.net_power.flight import PoweredFlight
from jaxatt.problems.net_power.wheels.form import WheelsForm
from jaxatt.problems.net_power.wheels.host import continuous, rotated
from jaxatt.problems.net_power.wheels.parameters import WheelsParameters
from jaxatt.problems.net_power.wheels.starts import Starts, filled, towards, with_powers
from jaxatt.problems.net_power.wheels.task import WheelsTask
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


def starts_from_flight(task: WheelsTask, flight: PoweredFlight, dipole: Floats | None) -> Starts:
    """Starts along flights of answers to a manoeuvre, on its own intervals.

    dipole : (S, N, 3) [A m^2], where it was decided.
    """
    p, form = task.parameters, task.form
    q = continuous(flight.q_ib)
    x = states_of(p, form, q, flight.omega_ib, flight.omega_bw)
    if form.charge:
        charge = flight.energy.charge / float(p.energy_scale)
        x = np.concatenate([x, charge[..., None]], axis=-1)
    x[:, 0] = np.asarray(p.start)
    scaled = np.clip(flight.wheel_torque / np.asarray(p.torque_limit), -INSIDE, INSIDE)
    both = None if dipole is None else dipoles_of(p, dipole)
    count = len(x)
    total = np.broadcast_to(np.asarray(p.total), (count, 3))
    u = with_powers(task, total, np.full(count, float(p.power_scale)), x, scaled, both)
    u = filled(u, len(np.asarray(p.stages.step)) - u.shape[1])
    x = filled(x, u.shape[1] + 1 - x.shape[1], still=True)
    reference = np.broadcast_to(np.asarray(p.reference), (count, 4))
    return Starts(u, x, towards(reference, q[:, -1]), np.zeros(count, int))
