"""Motion of a body with wheels while its torques are held."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Matrix, Vector, combination
from jaxatt.attitude.vectors import inverse
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.simulation.rigid_step import Body, Motion, runge_kutta
from jaxatt.spacecraft.vehicle import Spacecraft


class WheeledBody(NamedTuple):
    """Inertia and wheels of a vehicle, in scalars.

    axes : of the wheels.  wheel_inertia, per_inertia : (n,) [kg m^2] and its inverse.
    coulomb, viscous : (n,) [N m], [N m s], friction.
    """

    body: Body
    axes: tuple[Vector, ...]
    wheel_inertia: Array
    per_inertia: Array
    coulomb: Array
    viscous: Array

    def after_friction(
        self, motors: tuple[Array, ...], speeds: tuple[Array, ...], period: Array
    ) -> tuple[Array, ...]:
        """Torques [N m] that are left of the motors' after friction, as means over a period [s].

        By the wheels alone: viscous friction slows one down exponentially, and dry friction takes
        no more than what brings it to rest, where it then holds.
        """
        left = []
        for k, (motor, speed) in enumerate(zip(motors, speeds, strict=True)):
            inertia = self.wheel_inertia[k]
            damped = -jnp.expm1(-self.viscous[k] * self.per_inertia[k] * period) * inertia / period
            torque = motor - damped * speed
            stopping = speed * inertia / period + torque
            left.append(torque - jnp.clip(stopping, -self.coulomb[k], self.coulomb[k]))
        return tuple(left)

    def speeds(self, motion: Motion, spins: tuple[Array, ...]) -> tuple[Array, ...]:
        """Speeds of the wheels relative to the body [rad/s], from their axial momenta [N m s]."""
        return tuple(
            jnp.asarray(spins[k] * self.per_inertia[k] - axis.dot(motion.omega))
            for k, axis in enumerate(self.axes)
        )

    def spins(self, omega: Vector, speeds: Array) -> tuple[Array, ...]:
        """Axial momentum of each wheel [N m s] in the inertial frame; the inverse of `speeds`."""
        return tuple(
            self.wheel_inertia[k] * (speeds[k] + axis.dot(omega))
            for k, axis in enumerate(self.axes)
        )

    def advance(
        self,
        motion: Motion,
        spins: tuple[Array, ...],
        torque: Vector,
        dipole: Vector | None,
        along: Along,
        period: Array,
        torques: ExternalTorques,
    ) -> Motion:
        """Motion after one period with constant torques.

        torque : on the wheels in body axes [N m].  along : (steps, 4).
        """
        steps = jax.tree.leaves(along)[0].shape[0]
        step = period / steps

        def substep(
            carry: tuple[Motion, Vector], environment: Along
        ) -> tuple[tuple[Motion, Vector], None]:
            at, momentum = carry
            moved = runge_kutta(at, momentum, torque, dipole, environment, step, self.body, torques)
            return (moved, momentum + step * torque), None

        begin = motion, combination(self.axes, spins, motion.omega)
        if steps == 1:
            (end, _), _ = substep(begin, jax.tree.map(lambda x: x[0], along))
        else:
            (end, _), _ = lax.scan(substep, begin, along)
        return end


def wheeled_body(craft: Spacecraft) -> WheeledBody:
    """Convert a vehicle to scalars."""
    without_spin = jnp.asarray(craft.inertia_without_spin)
    inertia = jnp.asarray(craft.wheels.inertia)
    return WheeledBody(
        Body(*map(Matrix.of, (jnp.asarray(craft.inertia), without_spin, inverse(without_spin)))),
        tuple(Vector.of(jnp.asarray(craft.wheels.axes)[:, k]) for k in range(craft.wheels.count)),
        inertia,
        1.0 / inertia,
        jnp.asarray(craft.wheels.motors.coulomb),
        jnp.asarray(craft.wheels.motors.viscous),
    )
