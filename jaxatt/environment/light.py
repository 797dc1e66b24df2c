"""Sunlight along an orbit: direction of the sun, its irradiance and the Earth's shadow."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Scalar
from jaxatt.attitude.vectors import norm
from jaxatt.environment.eclipse import Shadow, lit_share
from jaxatt.environment.sun import ASTRONOMICAL_UNIT, sun_position
from jaxatt.runtime.arrays import Floats

_DIRECTION = 1e3  # shorter vectors are directions


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Light:
    """What shines on the panels.

    irradiance : [W/m^2].  sun : (3,) [m], position of the sun in inertial axes where it is fixed (a
    unit vector where only its direction matters); None for the true one by date.
    shadow : of the Earth; None where the sun always shines.
    """

    irradiance: Array | float
    sun: Array | Floats | None = None
    shadow: Shadow | None = None


def to_sun(light: Light, r_i: Array, days: Array | float) -> Array:
    """Vector (..., 3) [m] from a satellite to the sun, in inertial axes (J2000).

    r_i : (..., 3) [m], its position.  days : (...), since J2000.
    """
    if light.sun is None:
        return sun_position(jnp.asarray(days)) - r_i
    given = jnp.asarray(light.sun)
    size = norm(given)
    far = jnp.where(size < _DIRECTION, ASTRONOMICAL_UNIT / size, 1.0)
    return jnp.broadcast_to(given * far, r_i.shape) - r_i


def sunlight(
    light: Light, r_i: Array, days: Array | float, width: Scalar = 0.0
) -> tuple[Array, Array]:
    """Unit vector (..., 3) to the sun in inertial axes, and the share (...) of its light.

    r_i : (..., 3) [m].  days : (...), since J2000.
    width : () [rad], as in `lit_share`: 0 for the exact shadow.
    Traceable and differentiable in all arguments; the exact share has steps where `Shadow` has.
    """
    vector = to_sun(light, r_i, days)
    direction = vector / norm(vector)[..., None]
    if light.shadow is None:
        return direction, jnp.ones_like(direction[..., 0])
    return direction, lit_share(light.shadow, r_i, vector, width)
