"""Sunlight along an orbit: direction of the sun, its irradiance and the Earth's shadow."""

from __future__ import annotations

from dataclasses import dataclass

import jax
from jax import Array

from jaxatt.runtime.arrays import Floats


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Light:
    """What shines on the panels.

    irradiance : [W/m^2].  sun : (3,) [m], position of the sun in inertial axes where it is fixed (a
    unit vector where only its direction matters); None for the true one by date.
    """

    irradiance: Array | float
    sun: Array | Floats | None = None
