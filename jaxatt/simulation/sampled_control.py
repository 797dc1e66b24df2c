"""Measurement and control at a sampling instant."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Quaternion, Vector, combination
from jaxatt.control.feedback import FeedbackLaw, Measured
from jaxatt.environment.along_orbit import Nodes
from jaxatt.simulation.rigid_step import Motion
from jaxatt.simulation.run_state import RunState
from jaxatt.simulation.sampled_flight import Flight, Noise, Reference
from jaxatt.spacecraft.magnetorquers import limited
from jaxatt.spacecraft.wheel_motor import WheelMotors, torque_range


class Errors(NamedTuple):
    """Attitude q_ob and rate omega_ob [rad/s], and their errors relative to the reference."""

    q_ob: Quaternion
    omega_ob: Vector
    attitude: Quaternion
    rate: Vector


class Command(NamedTuple):
    """Torque on each wheel [N m] and dipole [A m^2], held until the next sample."""

    wheels: tuple[Array, ...]
    dipole: Vector | None


class Controller(NamedTuple):
    """A feedback law with the vehicle data that it uses.

    axes : of the wheels.  shares : rows of the allocation, one a wheel.  inertia : (n,) [kg m^2].
    torque_limit, speed_limit : (n,) [N m], [rad/s].  braking : (n,) [N m s], Jw / period.
    motors : whose torque falls with speed.
    """

    law: FeedbackLaw
    axes: tuple[Vector, ...]
    shares: tuple[Vector, ...]
    inertia: Array
    torque_limit: Array
    speed_limit: Array
    braking: Array
    motors: WheelMotors

    def decide(
        self,
        flight: Flight,
        state: RunState,
        speeds: tuple[Array, ...],
        errors: Errors,
        nodes: Nodes,
        reference: Reference,
        drawn: Array | None,
    ) -> tuple[Command, Any]:
        """Command for the next period, and the law's updated memory.

        speeds : of the wheels [rad/s].  drawn : (3 + n,), normal deviates; None without noise.
        """
        period = jnp.asarray(flight.period)
        omega, rate_error, seen = state.motion.omega, errors.rate, speeds
        if drawn is not None:
            shake, seen = _shaken(flight.noise, speeds, drawn)
            omega, rate_error = omega + shake, rate_error + shake
        spun = self.momentum(seen, omega)
        measured = Measured(
            state.sample * period, errors.attitude, rate_error, omega, spun, reference.feedforward
        )
        wanted, memory = self.law(measured, state.memory, period)
        dipole = _dipole(self, flight, state.motion, nodes, spun)
        return Command(self.limited(wanted, speeds), dipole), memory

    def momentum(self, speeds: Any, like: Vector) -> Vector:
        """Momentum A Jw omega_bw [N m s] of the wheels at speeds (n,) [rad/s]."""
        sizes = tuple(self.inertia[k] * speeds[k] for k in range(len(self.axes)))
        return combination(self.axes, sizes, like)

    def limited(self, wanted: Vector, speeds: tuple[Array, ...]) -> tuple[Array, ...]:
        """Torque on each wheel [N m] for a wanted torque in body axes, clipped to all limits.

        No more than brings the wheel to its speed limit within one period.
        """
        driven = []
        slow, fast = torque_range(self.motors, jnp.stack(speeds)) if speeds else ((), ())
        for k, share in enumerate(self.shares):
            least, most = (self.torque_limit[k] * end[k] for end in (slow, fast))
            up = jnp.clip(self.braking[k] * (self.speed_limit[k] - speeds[k]), least, most)
            down = jnp.clip(self.braking[k] * (-self.speed_limit[k] - speeds[k]), least, most)
            driven.append(jnp.clip(share.dot(wanted), down, up))
        return tuple(driven)


def controller(flight: Flight, law: FeedbackLaw) -> Controller:
    """Controller with the law and the flight's nominal vehicle."""
    wheels = flight.nominal.wheels
    inertia = jnp.asarray(wheels.inertia)
    return Controller(
        law,
        tuple(Vector.of(jnp.asarray(wheels.axes)[:, k]) for k in range(wheels.count)),
        tuple(Vector.of(wheels.allocation[k]) for k in range(wheels.count)),
        inertia,
        jnp.asarray(wheels.torque_limit),
        jnp.asarray(wheels.speed_limit),
        inertia / jnp.asarray(flight.period),
        jax.tree.map(jnp.asarray, wheels.motors),
    )


def measure(motion: Motion, nodes: Nodes, reference: Reference) -> Errors:
    """Errors without noise, with the attitude error taken the short way round."""
    q_ob = nodes.attitude.conjugate().multiply(motion.q_ib)
    omega_ob = motion.omega - q_ob.rotate_inverse(nodes.rate)
    error = reference.attitude.conjugate().multiply(q_ob).canonical()
    # Where only the rate is asked for, the attitude is right as it is.
    error = Quaternion(1.0 + reference.held * (error.eta - 1.0), reference.held * error.eps)
    return Errors(q_ob, omega_ob, error, omega_ob - reference.rate)


def deviates(key: Array, samples: Array, count: int) -> Array:
    """Draw the normal deviates (samples, 3 + count) of the samples with these numbers.

    All at once: inside the loop the generator would cost more than the flight.  32 bits of them
    are plenty, and half the work.
    """

    def one(sample: Array) -> Array:
        drawn = jax.random.normal(jax.random.fold_in(key, sample), (3 + count,), jnp.float32)
        return drawn.astype(float)

    return jax.vmap(one)(samples)


def _shaken(
    noise: Noise, speeds: tuple[Array, ...], drawn: Array
) -> tuple[Vector, tuple[Array, ...]]:
    """Noise on the rates [rad/s], and the measured wheel speeds."""
    shake = noise.rate * Vector(drawn[0], drawn[1], drawn[2])
    return shake, tuple(speed + noise.wheel_speed * drawn[3 + k] for k, speed in enumerate(speeds))


def _dipole(
    known: Controller, flight: Flight, motion: Motion, nodes: Nodes, spun: Vector
) -> Vector | None:
    """Dipole [A m^2] that unloads the wheels' momentum `spun` [N m s]; None without unloading."""
    if flight.dumping is None or nodes.field is None:
        return None
    assert flight.nominal.magnetorquers is not None
    kept = known.momentum(flight.dumping.reference, motion.omega)
    field_b = motion.q_ib.rotate_inverse(nodes.field)
    return limited(flight.nominal.magnetorquers, flight.dumping.dipole(spun - kept, field_b))
