"""A set of reaction wheels in any mounting that spans three directions."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp

from jaxatt.attitude.vectors import matvec
from jaxatt.spacecraft.parts.wheels import no_wheels as no_wheels
from jaxatt.spacecraft.parts.wheels import reaction_wheels as reaction_wheels
from jaxatt.spacecraft.parts.wheels import storage_share as storage_share
from jaxatt.spacecraft.pytrees import ReactionWheels as ReactionWheels


def momentum(wheels: ReactionWheels, omega_bw: Any) -> jax.Array:
    """Return the momentum of the wheels relative to the body, A Jw omega_bw.

    Parameters
    ----------
    wheels : ReactionWheels
    omega_bw : (..., n) array [rad/s]
        Wheel speeds relative to the body.

    Returns
    -------
    (..., 3) array [N m s]
        In body components; the wheel term of Schaanning (2021), eq. 4.8.
    """
    return matvec(wheels.axes * jnp.asarray(wheels.inertia)[..., None, :], omega_bw)
