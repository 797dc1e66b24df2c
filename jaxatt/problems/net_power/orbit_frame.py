"""The orbit frame at one instant, and attitudes that are given relative to it."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from jaxatt.environment import frames, kepler, orbit
from jaxatt.problems.manoeuvre import InitialState
from jaxatt.problems.net_power.plan.task import Pose, product
from jaxatt.problems.scenario import Orbit
from jaxatt.problems.surroundings import elements_of
from jaxatt.runtime.arrays import Floats


@jax.jit
def _frame(
    elements: kepler.KeplerianElements, mu: jax.Array, time: jax.Array
) -> tuple[jax.Array, jax.Array]:
    r_i, v_i = orbit.propagate(*kepler.to_state(elements, mu), time, mu)
    return frames.quaternion_io(r_i, v_i), frames.omega_io(r_i, v_i)


def orbit_frame(around: Orbit) -> Callable[[float], Pose]:
    """Function that gives attitude q_io and rate omega_io, in orbit axes, at a time [s]."""
    elements, mu = elements_of(around), jnp.asarray(around.gravitational_parameter)

    def at(time: float) -> Pose:
        return Pose(*map(np.asarray, _frame(elements, mu, jnp.asarray(time))))

    return at


def rotated_back(q: Floats, v: Floats) -> Floats:
    """Vector R(q)' v (3,), in NumPy."""
    twice = 2.0 * np.cross(-q[1:], v)
    return np.asarray(v + q[0] * twice + np.cross(-q[1:], twice))


def inertial_pose(state: InitialState, frame: str, around: Orbit | None, time: float = 0.0) -> Pose:
    """Inertial attitude and rate of a state that is given in "inertial" or "orbit" axes."""
    if frame == "inertial" or around is None:
        return Pose(state.q_ob, state.omega_ob)
    reference = orbit_frame(around)(time)
    carried = rotated_back(state.q_ob, reference.omega_ib)
    return Pose(product(reference.q_ib, state.q_ob), state.omega_ob + carried)
