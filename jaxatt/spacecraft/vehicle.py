"""A rigid body with actuators, solar panels and a battery."""

from __future__ import annotations

from typing import Any

import jax

from jaxatt.attitude.vectors import matvec
from jaxatt.spacecraft.parts.vehicle import create as create
from jaxatt.spacecraft.pytrees import Spacecraft as Spacecraft
from jaxatt.spacecraft.wheels import momentum


def total_momentum(spacecraft: Spacecraft, omega_ib: Any, omega_bw: Any) -> jax.Array:
    """Return the angular momentum of body and wheels, J omega_ib + A Jw omega_bw.

    Parameters
    ----------
    spacecraft : Spacecraft
    omega_ib : (..., 3) array [rad/s]
        Rate of the body relative to the inertial frame, in body axes.
    omega_bw : (..., n) array [rad/s]
        Wheel speeds relative to the body.

    Returns
    -------
    (..., 3) array [N m s]
        In body axes; Schaanning (2021), eq. 4.8.
    """
    return matvec(spacecraft.inertia, omega_ib) + momentum(spacecraft.wheels, omega_bw)
