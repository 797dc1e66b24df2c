"""Position and velocity of a scenario's orbit, and its orbit frame, at given times on the host."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.attitude.host_turns import conjugate, product, to_body
from jaxatt.environment import frames
from jaxatt.environment.motion import Motion
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE


class AlongOrbit(NamedTuple):
    """Where a spacecraft is at n times, and its orbit frame.

    position : (n, 3) [m] and velocity : (n, 3) [m/s], in inertial axes.
    q_io : (n, 4), attitude of the orbit frame.  omega_io : (n, 3) [rad/s], its rate, in its axes.
    """

    position: Floats
    velocity: Floats
    q_io: Floats
    omega_io: Floats


def along_orbit(motion: Motion, time: Floats) -> AlongOrbit:
    """Motion along an orbit at times (n,) [s] after the start, whatever precision JAX has."""
    with jax.enable_x64(True):
        found = _evaluated(motion, jnp.asarray(time))
    return AlongOrbit(*map(np.asarray, found))


def to_inertial(
    motion: Motion | None, time: Floats, q_ob: Floats, omega_ob: Floats
) -> tuple[Floats, Floats]:
    """Attitude q_ib (n, 4) and rate omega_ib (n, 3) [rad/s] of those relative to the orbit frame.

    motion : None where the frame of reference is inertial.
    """
    if motion is None:
        return q_ob, omega_ob
    frame = along_orbit(motion, time)
    return product(frame.q_io, q_ob), omega_ob + to_body(q_ob, frame.omega_io)


def from_inertial(
    motion: Motion | None, time: Floats, q_ib: Floats, omega_ib: Floats
) -> tuple[Floats, Floats]:
    """Attitude q_ob (n, 4) and rate omega_ob (n, 3) [rad/s] of inertial ones."""
    if motion is None:
        return q_ib, omega_ib
    frame = along_orbit(motion, time)
    q_ob = product(conjugate(frame.q_io), q_ib)
    return q_ob, omega_ib - to_body(q_ob, frame.omega_io)


def _evaluate(motion: Motion, time: Array) -> tuple[Array, Array, Array, Array]:
    here = motion.at(time)
    attitude = frames.quaternion_io(here.position, here.velocity)
    return here.position, here.velocity, attitude, frames.omega_io(*here)


_evaluated = jax.jit(_evaluate, compiler_options=RUNS_ONCE)
