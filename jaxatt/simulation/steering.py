"""What a flight holds over an interval: given wheel torques, or those of a PD law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.control.proportional_derivative import proportional_derivative
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.rigid_step import Motion

Torques = tuple[Array, ...]


class Steering(Protocol):
    """Decides at the start of an interval, from the motion and the interval's own row of data."""

    def __call__(self, motion: Motion, row: Any) -> Torques:
        """Torque on each wheel [N m], held over the interval."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class GivenTorque:
    """The torques of the row itself."""

    def __call__(self, motion: Motion, row: Any) -> Torques:
        """Torque on each wheel [N m]; row : the same."""
        torque: Torques = row
        return torque


class Aim(NamedTuple):
    """Attitude q_ib and rate omega_ib [rad/s] to turn to."""

    q_ib: Quaternion
    rate: Vector


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class HeldPD:
    """PD law whose torque is held, K_p eps_e + K_d (omega - omega_ref) on the wheels.

    proportional : () [N m].  derivative : () [N m s].  shares : (n, 3), from body to wheel torque.
    torque_limit : (n,) [N m], clips each wheel.
    Source: Kristiansen (2023), eqs. (3.6) and (3.7), the attitude error taken the short way round.
    """

    proportional: Array | float
    derivative: Array | float
    shares: Array | Floats
    torque_limit: Array | Floats

    def __call__(self, motion: Motion, row: Any) -> Torques:
        """Torque on each wheel [N m]; row : an `Aim`."""
        error = row.q_ib.conjugate().multiply(motion.q_ib).canonical()
        wanted = proportional_derivative(
            error.eps, motion.omega - row.rate, self.proportional, self.derivative
        )
        return tuple(
            jnp.clip(Vector.of(share).dot(wanted), -most, most)
            for share, most in zip(self.shares, self.torque_limit, strict=True)
        )
