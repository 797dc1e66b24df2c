"""Flight under a sampled feedback law, written for thousands of runs at once.

One run is written in scalars; `jax.vmap` maps it over a batch.  Torques are computed at the
sampling instants and held; the body moves by Runge-Kutta steps in between.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Matrix, Quaternion, Scalar, Vector
from jaxatt.attitude.vectors import inverse
from jaxatt.control.feedback import FeedbackLaw, Measured
from jaxatt.control.momentum_dumping import MomentumDumping
from jaxatt.environment.along_orbit import Nodes
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.simulation.rigid_step import Body, Motion, runge_kutta
from jaxatt.simulation.settling import (
    Band,
    Channel,
    Effort,
    Figures,
    channel,
    figures,
    follow,
    spend,
)
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft

FLYING, TUMBLING, NOT_FINITE = 0, 1, 2
"""What became of a run."""


class Reference(NamedTuple):
    """What is asked at every sample; leading axis (samples,).

    attitude : q_d, relative to the frame of reference.  rate : omega_d [rad/s], body axes.
    held : 1 where the attitude is to be held, 0 where only the rate is.
    feedforward : torque on the wheels in body axes [N m].
    """

    attitude: Quaternion
    rate: Vector
    held: Array
    feedforward: Vector


class Noise(NamedTuple):
    """Standard deviations of what is measured: rate [rad/s] and wheel speed [rad/s]."""

    rate: Array | float
    wheel_speed: Array | float


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Flight:
    """Everything that all runs share.

    nominal : the vehicle as the controller knows it.  torques : that act from outside.
    along : leading axes (records, samples, steps, 4).  nodes, reference : (records, samples).
    ends : nodes and reference at the end of each record, (records,).
    period : () [s], of sampling; the torque is held over it (zero-order hold).
    dumping : None where the magnetorquers rest.
    tumbling : () [rad/s], rate above which a run counts as diverged.
    signal : "attitude" or "rate" (static), which error `band` watches.
    noisy : whether noise is drawn at all (static).
    """

    nominal: Spacecraft
    torques: ExternalTorques
    along: Along
    nodes: Nodes
    reference: Reference
    ends: tuple[Nodes, Reference]
    period: Array
    band: Band
    noise: Noise
    dumping: MomentumDumping | None
    tumbling: Array | float = 10.0
    signal: str = field(default="attitude", metadata={"static": True})
    noisy: bool = field(default=False, metadata={"static": True})


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Recorded:
    """A run at the end of each record, torques as held until then; leading axes (..., records).

    q_ob : (..., 4).  error : (..., 3), vector part of the error quaternion, eta >= 0.
    rate_error, omega_ob : (..., 3) [rad/s].  omega_bw : (..., n) [rad/s].
    wheel_torque : (..., n) [N m], on each wheel.  dipole : (..., 3) [A m^2].
    """

    q_ob: Array
    error: Array
    rate_error: Array
    omega_ob: Array
    omega_bw: Array
    wheel_torque: Array
    dipole: Array


class Flown(NamedTuple):
    """What a run leaves: `what` is FLYING, TUMBLING or NOT_FINITE, `ended` [s] when it failed."""

    figures: Figures
    what: Array
    ended: Array
    recorded: Recorded


class _State(NamedTuple):
    motion: Motion
    spins: tuple[Array, ...]  # axial momentum of each wheel, inertial [N m s]
    memory: Any
    channels: tuple[Channel, ...]
    effort: Effort
    driven: tuple[Array, ...]  # wheel torques held until the next sample
    dipole: Vector
    what: Array
    ended: Array
    sample: Array


def fly(
    flight: Flight, craft: Spacecraft, start: AttitudeState, law: FeedbackLaw, key: Array
) -> Flown:
    """One run.

    craft : the vehicle as it is, which may differ from the nominal one.
    start : q_ob, omega_ib, omega_bw at time zero.  law : its gains.  key : of the noise.
    """
    count = craft.wheels.count
    inertia = jnp.asarray(craft.inertia)
    without_spin = jnp.asarray(craft.inertia_without_spin)
    body = Body(*map(Matrix.of, (inertia, without_spin, inverse(without_spin))))
    axes = tuple(Vector.of(jnp.asarray(craft.wheels.axes)[:, k]) for k in range(count))
    per_inertia = 1.0 / jnp.asarray(craft.wheels.inertia)
    known = flight.nominal.wheels
    known_axes = tuple(Vector.of(jnp.asarray(known.axes)[:, k]) for k in range(count))
    shares = tuple(Vector.of(known.allocation[k]) for k in range(count))
    known_inertia = jnp.asarray(known.inertia)
    torque_limit, speed_limit = jnp.asarray(known.torque_limit), jnp.asarray(known.speed_limit)
    steps = jax.tree.leaves(flight.along)[0].shape[2]
    period = jnp.asarray(flight.period)
    step = period / steps
    braking = known_inertia / period

    band = flight.band
    if flight.signal == "attitude":
        # Sines of half the angles are watched: the loop then needs no inverse functions.
        band = Band(jnp.sin(0.5 * band.width), band.since)

    def signal(error: Quaternion, rate_error: Vector) -> tuple[Scalar, ...]:
        watched = error.eps if flight.signal == "attitude" else rate_error
        return (*watched.parts, watched.norm())

    def speeds(state: _State) -> tuple[Array, ...]:
        omega = state.motion.omega
        return tuple(
            jnp.asarray(state.spins[k] * per_inertia[k] - axes[k].dot(omega)) for k in range(count)
        )

    def measure(
        state: _State, nodes: Nodes, reference: Reference
    ) -> tuple[Quaternion, Vector, Quaternion, Vector]:
        q_ob = nodes.attitude.conjugate().multiply(state.motion.q_ib)
        omega_ob = state.motion.omega - q_ob.rotate_inverse(nodes.rate)
        error = reference.attitude.conjugate().multiply(q_ob).canonical()
        # Where only the rate is asked for, the attitude is right as it is.
        error = Quaternion(1.0 + reference.held * (error.eta - 1.0), reference.held * error.eps)
        return q_ob, omega_ob, error, omega_ob - reference.rate

    def decide(
        state: _State,
        nodes: Nodes,
        reference: Reference,
        error: Quaternion,
        rate_error: Vector,
        drawn: Array | None,
    ) -> tuple[tuple[Array, ...], Any, Vector | None]:
        """Wheel torques, the law's memory and the dipole, all held until the next sample."""
        turning = speeds(state)
        omega, seen = state.motion.omega, turning
        if drawn is not None:
            shake = flight.noise.rate * Vector(drawn[0], drawn[1], drawn[2])
            omega, rate_error = omega + shake, rate_error + shake
            seen = tuple(turning[k] + flight.noise.wheel_speed * drawn[3 + k] for k in range(count))
        spun = sum(
            (known_axes[k] * (known_inertia[k] * seen[k]) for k in range(count)), _zero(omega)
        )
        measured = Measured(
            state.sample * period, error, rate_error, omega, spun, reference.feedforward
        )
        wanted, memory = law(measured, state.memory, period)
        driven = []
        for k in range(count):
            most = torque_limit[k]
            # No more than brings the wheel to its speed limit within one period.
            up = jnp.clip(braking[k] * (speed_limit[k] - turning[k]), -most, most)
            down = jnp.clip(braking[k] * (-speed_limit[k] - turning[k]), -most, most)
            driven.append(jnp.clip(shares[k].dot(wanted), down, up))
        dipole = None
        if flight.dumping is not None and nodes.field is not None:
            assert flight.nominal.magnetorquers is not None
            kept = sum(
                (
                    known_axes[k] * (known_inertia[k] * flight.dumping.reference[k])
                    for k in range(count)
                ),
                _zero(omega),
            )
            field_b = state.motion.q_ib.rotate_inverse(nodes.field)
            asked = flight.dumping.dipole(spun - kept, field_b)
            dipole = flight.nominal.magnetorquers.limited(asked)
        return tuple(driven), memory, dipole

    def sample(
        state: _State, inputs: tuple[Along, Nodes, Reference], drawn: Array | None
    ) -> _State:
        along, nodes, reference = inputs
        _, omega_ob, error, rate_error = measure(state, nodes, reference)
        driven, memory, dipole = decide(state, nodes, reference, error, rate_error, drawn)
        torque = sum((axes[k] * driven[k] for k in range(count)), _zero(omega_ob))
        spun = sum((axes[k] * state.spins[k] for k in range(count)), _zero(omega_ob))

        def substep(
            carry: tuple[Motion, Vector], environment: Along
        ) -> tuple[tuple[Motion, Vector], None]:
            motion, momentum = carry
            moved = runge_kutta(
                motion, momentum, torque, dipole, environment, step, body, flight.torques
            )
            return (moved, momentum + step * torque), None

        if steps == 1:
            (motion, _), _ = substep((state.motion, spun), jax.tree.map(lambda x: x[0], along))
        else:
            (motion, _), _ = lax.scan(substep, (state.motion, spun), along)
        time = state.sample * period
        channels = tuple(
            follow(c, e, time, period, band)
            for c, e in zip(state.channels, signal(error, rate_error), strict=True)
        )
        spins = tuple(state.spins[k] + period * driven[k] for k in range(count))
        moved = _State(
            motion,
            spins,
            memory,
            channels,
            spend(state.effort, torque, period),
            driven,
            dipole if dipole is not None else _zero(omega_ob),
            state.what,
            state.ended,
            state.sample + 1,
        )
        return _judged(state, moved, time, flight.tumbling)

    def record(
        state: _State, inputs: tuple[tuple[Along, Nodes, Reference], tuple[Nodes, Reference]]
    ) -> tuple[_State, Array]:
        within, end = inputs
        drawn = None
        if flight.noisy:
            # All at once: inside the loop the generator would cost more than the flight.
            samples = state.sample + jnp.arange(within[2].held.shape[0])
            drawn = jax.vmap(lambda k: _shaken(jax.random.fold_in(key, k), 3 + count))(samples)
        state, _ = lax.scan(lambda s, i: (sample(s, *i), None), state, (within, drawn))
        q_ob, omega_ob, error, rate_error = measure(state, *end)
        row = (
            *(q_ob.eta, *q_ob.eps.parts),
            *error.eps.parts,
            *rate_error.parts,
            *omega_ob.parts,
            *speeds(state),
            *state.driven,
            *state.dipole.parts,
            *signal(error, rate_error),
        )
        return state, jnp.stack([jnp.asarray(value) for value in row])

    begun = _begin(flight, craft, start, law)
    within = (flight.along, flight.nodes, flight.reference)
    end, rows = lax.scan(record, begun, (within, flight.ends))
    sizes = (4, 3, 3, 3, count, count, 3)
    edges = [sum(sizes[: i + 1]) for i in range(len(sizes))]
    *recorded, errors = jnp.split(rows, edges, axis=1)
    total = end.sample * period
    found = figures(end.channels, end.effort, band, errors[-1], total)
    if flight.signal == "attitude":
        found = found._replace(rms=_angle(found.rms), final=_angle(found.final))
    return Flown(found, end.what, end.ended, Recorded(*recorded))


def _angle(sine: Array) -> Array:
    """Angle [rad] of the sine of its half."""
    return 2.0 * jnp.arcsin(jnp.clip(sine, -1.0, 1.0))


def _shaken(key: Array, count: int) -> Array:
    """Normal deviates (count,); 32 bits of them are plenty, and half the work."""
    return jax.random.normal(key, (count,), jnp.float32).astype(float)


def _zero(like: Vector) -> Vector:
    zero = 0.0 * like.x
    return Vector(zero, zero, zero)


def _judged(before: _State, after: _State, time: Array, tumbling: Array | float) -> _State:
    """What follows a sample; a run that fails stays where it last was sound."""
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


def _begin(flight: Flight, craft: Spacecraft, start: AttitudeState, law: FeedbackLaw) -> _State:
    omega = Vector.of(start.omega_ib)
    first = jax.tree.map(lambda x: x[0, 0], flight.nodes)
    zero = 0.0 * jnp.asarray(omega.x)
    wheels = craft.wheels
    spins = tuple(
        jnp.asarray(wheels.inertia)[k]
        * (start.omega_bw[k] + Vector.of(jnp.asarray(wheels.axes)[:, k]).dot(omega))
        for k in range(wheels.count)
    )
    return _State(
        motion=Motion(first.attitude.multiply(Quaternion.of(start.q_ob)), omega),
        spins=spins,
        memory=jax.tree.map(lambda leaf: leaf + zero, law.initial()),
        channels=tuple(channel(zero) for _ in range(4)),
        effort=Effort(zero, Vector(zero, zero, zero)),
        driven=tuple(zero for _ in range(wheels.count)),
        dipole=Vector(zero, zero, zero),
        what=jnp.asarray(FLYING),
        ended=zero + jnp.inf,
        sample=jnp.asarray(0),
    )
