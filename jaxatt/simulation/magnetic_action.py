"""Dipole of the magnetorquers during a step: held, or following the wheels' momentum."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from jaxatt.attitude.components import Matrix, Vector
from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment.external import Along
from jaxatt.simulation.rigid_step import Motion
from jaxatt.spacecraft.magnetorquers import Magnetorquers, limited
from jaxatt.spacecraft.vehicle import Spacecraft
from jaxatt.spacecraft.wheels import momentum


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class MomentumHold:
    """Magnetorquers that unload the wheels at every instant, not only at sampling times.

    law : its reference the wheel speeds to keep.  kept : A Jw omega_ref [N m s], in body axes.
    spin_inertia : A Jw A' [kg m^2].  magnetorquers : whose limits clip the dipole.
    Source: Kristiansen (2023), eqs. (5.14) and (5.15).
    """

    law: MomentumDumping
    kept: Vector
    spin_inertia: Matrix
    magnetorquers: Magnetorquers

    def __call__(self, motion: Motion, spun: Vector, along: Along) -> Vector:
        """Dipole [A m^2]; spun : A h, of the wheels' axial momenta in the inertial frame."""
        assert along.field is not None
        relative = spun - self.spin_inertia @ motion.omega
        field_b = motion.q_ib.rotate_inverse(along.field)
        return limited(self.magnetorquers, self.law.dipole(relative - self.kept, field_b))


def momentum_hold(
    craft: Spacecraft, magnetorquers: Magnetorquers, law: MomentumDumping
) -> MomentumHold:
    """The law in the components of a vehicle."""
    wheels = craft.wheels
    kept = Vector.of(momentum(wheels, law.reference))
    return MomentumHold(law, kept, Matrix.of(jnp.asarray(wheels.spin_inertia_body)), magnetorquers)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class HeldDipole:
    """The same dipole [A m^2] in body axes throughout; None where there are no magnetorquers."""

    dipole: Vector | None = None

    def __call__(self, motion: Motion, spun: Vector, along: Along) -> Vector | None:
        """Dipole [A m^2] in the shape of the motion."""
        if self.dipole is None:
            return None
        return self.dipole.map(lambda m, like: jnp.broadcast_to(m, jnp.shape(like)), motion.omega)
