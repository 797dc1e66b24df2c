"""Torques corrected a little so that their flight ends where it was asked to.

A torque that was found for one start drifts where it is flown from another that differs by little:
over an hour a microradian a second makes a quarter of a degree.  A differential correction adds two
constant torques in body axes, one after the other in the middle of the manoeuvre, of the size that
flights with a little more of each say.
"""

from __future__ import annotations

import numpy as np

from jaxatt.problems.net_power.flight import PoweredFlight, fly
from jaxatt.problems.net_power.manoeuvre import End, Manoeuvre
from jaxatt.problems.net_power.wheels.host import conjugate, logarithm, product
from jaxatt.runtime.arrays import Floats

_ENOUGH = 0.02
"""Share of the tolerances with which a correction is content."""
_MOST = 3


def corrected(manoeuvre: Manoeuvre, torque: Floats, dipole: Floats | None = None) -> Floats:
    """Torques (N, n) [N m] that end in the manoeuvre's attitude and rate.

    torque : (N, n) [N m] and dipole : (N, 3) [A m^2], whose flight ends near there.
    Torques stay within their limits; where that leaves no way, the flight still misses.
    """
    end, craft = manoeuvre.end, manoeuvre.satellite.craft
    if end is None or manoeuvre.terminal != "reach":
        return torque
    limit, axes = np.asarray(craft.wheels.torque_limit), np.asarray(craft.wheels.axes)
    ways = _ways(len(torque), np.linalg.pinv(axes))
    # A torque that alone turns the lightest axis by about the tolerance; larger ones may tumble it.
    inertia = np.linalg.eigvalsh(np.asarray(craft.inertia_without_spin)).min()
    trial = end.attitude_tolerance * inertia / manoeuvre.duration**2
    for _ in range(_MOST):
        tried = np.concatenate([torque[None], torque + trial * ways])
        held = None if dipole is None else np.repeat(dipole[None], len(tried), axis=0)
        missed = _missed(end, fly(manoeuvre, tried, held))
        if not np.isfinite(missed).all() or np.abs(missed[0]).max() < _ENOUGH:
            break
        by_trial = (missed[1:] - missed[0]).T
        amounts = -np.linalg.lstsq(by_trial, missed[0])[0]
        torque = np.clip(torque + trial * np.tensordot(amounts, ways, 1), -limit, limit)
    return torque


def _ways(intervals: int, spread: Floats) -> Floats:
    """Wheel torques (6, N, n) of a unit torque about each body axis, in two parts of the middle.

    spread : (n, 3), wheel torques that make a torque in body axes.
    """
    edge = intervals // 4
    parts = np.array_split(np.arange(edge, intervals - edge), 2)
    ways = np.zeros((2, 3, intervals, len(spread)))
    for when, part in zip(ways, parts, strict=True):
        when[:, part] = spread.T[:, None]
    found: Floats = ways.reshape(6, intervals, len(spread))
    return found


def _missed(end: End, flight: PoweredFlight) -> Floats:
    """Errors (S, 6) of attitude and rate at the end over their tolerances."""
    end = end.facing(flight.q_ib[:, -1])
    turn = logarithm(product(conjugate(end.q_ib), flight.q_ib[:, -1]))
    rate = flight.omega_ib[:, -1] - end.omega_ib
    return np.concatenate([turn / end.attitude_tolerance, rate / end.rate_tolerance], axis=1)
