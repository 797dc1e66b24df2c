"""Magnetorquers: coils or rods that make a magnetic dipole."""

from __future__ import annotations

import jax.numpy as jnp

from jaxatt.attitude.components import Vector
from jaxatt.spacecraft.parts.magnetorquers import magnetorquers as magnetorquers
from jaxatt.spacecraft.pytrees import Magnetorquers as Magnetorquers


def limited(torquers: Magnetorquers, dipole: Vector) -> Vector:
    """Dipole [A m^2] after clipping to what the magnetorquers can give."""
    limit = Vector.of(torquers.dipole_limit)
    return dipole.map(lambda m, most: jnp.clip(m, -most, most), limit)
