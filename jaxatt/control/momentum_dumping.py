"""Unloading of the wheels' momentum by magnetorquers."""

from __future__ import annotations

from dataclasses import dataclass, field

import jax
from jax import Array

from jaxatt.attitude.components import Vector


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class MomentumDumping:
    """Cross-product law for unloading: dipole k_m (h_e x B) / |B|^p.

    gain : () [1/s] with p = 2.  reference : (n,) [rad/s], wheel speeds to keep.
    printed : True for p = 1 (static), as Kristiansen (2023) prints in eq. (11.26): that is weaker
    by 1/|B|, some thirty thousand times, and dumps nothing within days.
    """

    gain: Array | float
    reference: Array
    printed: bool = field(default=False, metadata={"static": True})

    def dipole(self, momentum_error: Vector, field_b: Vector) -> Vector:
        """Dipole [A m^2] of the magnetorquers in body axes.

        momentum_error : A Jw (omega_bw - reference) [N m s].  field_b : [T].
        """
        squared = field_b.dot(field_b)
        strength = field_b.norm() if self.printed else squared
        return momentum_error.cross(field_b) * (self.gain / strength)
