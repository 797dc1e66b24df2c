"""State of a run between two samples, and the test whether it has failed."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from jaxatt.attitude.components import Quaternion, Vector
from jaxatt.control.feedback import FeedbackLaw
from jaxatt.simulation.rigid_step import Motion
from jaxatt.simulation.sampled_flight import FLYING, NOT_FINITE, TUMBLING, Flight
from jaxatt.simulation.settling import CHANNELS, Channel, Effort, channel
from jaxatt.simulation.wheeled_body import WheeledBody
from jaxatt.spacecraft.dynamics import AttitudeState


class RunState(NamedTuple):
    """State of a run at a sampling instant.

    spins : axial momentum of each wheel, inertial [N m s].  memory : the law's.
    driven, dipole : wheel torques [N m] and dipole [A m^2] held until now.
    saturated : samples so far at which a dipole was at its limit.
    what, ended : as in `Flown`.  sample : number of the next sample.
    """

    motion: Motion
    spins: tuple[Array, ...]
    memory: Any
    channels: tuple[Channel, ...]
    effort: Effort
    driven: tuple[Array, ...]
    dipole: Vector
    saturated: Array
    what: Array
    ended: Array
    sample: Array


def begin(flight: Flight, body: WheeledBody, start: AttitudeState, law: FeedbackLaw) -> RunState:
    """State of a run before the first sample."""
    omega = Vector.of(start.omega_ib)
    first = jax.tree.map(lambda x: x[0, 0], flight.nodes)
    zero = 0.0 * jnp.asarray(omega.x)
    nothing = Vector(zero, zero, zero)
    return RunState(
        motion=Motion(first.attitude.multiply(Quaternion.of(start.q_ob)), omega),
        spins=body.spins(omega, start.omega_bw),
        memory=jax.tree.map(lambda leaf: leaf + zero, law.initial()),
        channels=tuple(channel(zero) for _ in CHANNELS),
        effort=Effort(zero, nothing),
        driven=tuple(zero for _ in body.axes),
        dipole=nothing,
        saturated=zero,
        what=jnp.asarray(FLYING),
        ended=zero + jnp.inf,
        sample=jnp.asarray(0),
    )


def judged(before: RunState, after: RunState, time: Array, tumbling: Array | float) -> RunState:
    """The new state; a run that fails keeps its last finite state and is marked as failed."""
    omega = after.motion.omega
    leaves = jax.tree.leaves((after.motion, after.spins, after.memory))
    sound = jnp.isfinite(sum(jnp.sum(0.0 * leaf) for leaf in leaves))
    tumbles = jnp.asarray(omega.dot(omega)) > tumbling**2
    now = jnp.where(sound, jnp.where(tumbles, TUMBLING, FLYING), NOT_FINITE)
    flying = before.what == FLYING
    fails = flying & (now != FLYING)

    def held(new: Any, old: Any) -> Any:
        return jax.tree.map(lambda x, y: jnp.where(flying & ~fails, x, y), new, old)

    return after._replace(
        motion=held(after.motion, before.motion),
        spins=held(after.spins, before.spins),
        memory=held(after.memory, before.memory),
        what=jnp.where(fails, now, before.what),
        ended=jnp.where(fails, time, before.ended),
    )
