"""Magnetorquers: coils or rods that make a magnetic dipole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.attitude.components import Vector
from jaxatt.spacecraft.checks import FieldError, Float64, finite_array


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class Magnetorquers:
    """One magnetorquer on each body axis; build them with `magnetorquers`, which checks the
    numbers.

    dipole_limit : (3,) [A m^2], largest absolute dipole about each axis.
    """

    dipole_limit: jax.Array | Float64

    def limited(self, dipole: Vector) -> Vector:
        """Dipole [A m^2] after clipping to what the magnetorquers can give."""
        limit = Vector.of(self.dipole_limit)
        return dipole.map(lambda m, most: jnp.clip(m, -most, most), limit)


def magnetorquers(dipole_limit: Any) -> Magnetorquers:
    """Return checked magnetorquers.

    dipole_limit : float or (3,) [A m^2], greater than 0.
    Raises `FieldError`, a `ValueError`.
    """
    limit = finite_array("dipole_limit", dipole_limit)
    if limit.shape not in ((), (3,)):
        raise FieldError(
            "dipole_limit",
            f"has shape {limit.shape}; give one number for all or three numbers, one a body axis",
        )
    if not (limit > 0.0).all():
        raise FieldError(
            "dipole_limit", f"holds {limit.min():g}; every value must be greater than 0"
        )
    return Magnetorquers(np.broadcast_to(limit, (3,)).copy())
