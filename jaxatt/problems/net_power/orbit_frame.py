"""The orbit frame at one instant, and states that are given relative to it."""

from __future__ import annotations

import functools

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import frames
from jaxatt.environment.along_orbit import OrbitTask
from jaxatt.environment.motion import Motion
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.net_power.pose import Pose, product
from jaxatt.runtime.arrays import Floats
from jaxatt.runtime.settings import RUNS_ONCE


def orbit_frame(flown: OrbitTask, time: float) -> Pose:
    """Attitude q_io, and rate omega_io in orbit axes, of the orbit frame at a time [s]."""
    q_io, rate = _frame(flown.motion, jnp.asarray(time))
    return Pose(np.asarray(q_io), np.asarray(rate))


@functools.partial(jax.jit, compiler_options=RUNS_ONCE)
def _frame(motion: Motion, time: jax.Array) -> tuple[jax.Array, jax.Array]:
    here = motion.at(time)
    return frames.quaternion_io(here.position, here.velocity), frames.omega_io(*here)


def rotated_back(q: Floats, v: Floats) -> Floats:
    """Vector R(q)' v (3,), in NumPy."""
    twice = 2.0 * np.cross(-q[1:], v)
    return np.asarray(v + q[0] * twice + np.cross(-q[1:], twice))


def inertial_pose(
    state: InitialState, frame: str, flown: OrbitTask | None, time: float = 0.0
) -> Pose:
    """Inertial attitude and rate of a state that is given in "inertial" or "orbit" axes."""
    if frame == "inertial" or flown is None:
        return Pose(state.q_ob, state.omega_ob)
    reference = orbit_frame(flown, time)
    carried = rotated_back(state.q_ob, reference.omega_ib)
    return Pose(product(reference.q_ib, state.q_ob), state.omega_ob + carried)
