"""What the second derivatives of an interval use again from the first."""

from __future__ import annotations

from typing import NamedTuple

from jax import Array

from jaxatt.problems.net_power.wheels.wheel_limits import Turning


class Kept(NamedTuple):
    """What the Hessian of an interval uses again; z is error state, then controls.

    turn : (3,), rotation vector of the interval, nearly.  chart : (3, 3), of the gap.
    back : (3, 3), R(dq)'.  motion : (9, z), turn at the end of the interval by z, other than that
    of the body itself, and omega_ib at the beginning and at the end [rad/s].
    sunlit : (6,), Hessian of the sunlight by the turn.
    spins : (2, r, z) [rad/s], wheel speeds of the power by z at both ends, or none.
    wheels : speeds of all wheels at both ends, or none.
    dipole : (3,) and by_dipole : (3, z) [A m^2], or none.
    """

    turn: Array
    chart: Array
    back: Array
    motion: Array
    sunlit: Array
    spins: Array
    wheels: Turning
    dipole: Array
    by_dipole: Array
