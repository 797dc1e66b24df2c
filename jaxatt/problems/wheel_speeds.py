"""Speed limits of wheels, as flights keep or break them."""

from __future__ import annotations

import numpy as np
from jax import Array

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.wheels import ReactionWheels


def speed_excess(wheels: ReactionWheels, omega_bw: Floats | Array) -> Floats:
    """Largest speed of each wheel over its limit, as a share of the limit, (S, n).

    omega_bw : (S, nodes, n) [rad/s].  Negative where a limit is kept, -1 where there is none.
    """
    relative = np.abs(np.asarray(omega_bw)) / np.asarray(wheels.speed_limit) - 1.0
    return np.asarray(relative.max(axis=1, initial=-1.0))


def broken_speeds(wheels: ReactionWheels, excess: Floats, tolerance: float) -> list[str]:
    """Words on each wheel that turns faster than it may; excess : (n,), as `speed_excess`."""
    limits = np.broadcast_to(np.asarray(wheels.speed_limit, float), excess.shape)
    return [
        f"{name} turns {100.0 * over:.3g} % faster than its limit of {limit:g} rad/s"
        for name, over, limit in zip(wheels.names, excess, limits, strict=True)
        if over > tolerance
    ]
