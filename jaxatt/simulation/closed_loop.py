"""Flight under a sampled feedback law, efficient for thousands of runs at once.

One run is written in scalars; `jax.vmap` maps it over a batch.  Torques are computed at the
sampling instants and held; the body moves by Runge-Kutta steps in between.
"""

from __future__ import annotations

import itertools

import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Scalar, Vector, combination
from jaxatt.control.feedback import FeedbackLaw
from jaxatt.environment.along_orbit import Nodes
from jaxatt.environment.external import Along
from jaxatt.simulation.run_state import RunState, begin, judged
from jaxatt.simulation.sampled_control import Controller, Errors, controller, deviates, measure
from jaxatt.simulation.sampled_flight import (
    FLYING,
    NOT_FINITE,
    TUMBLING,
    Flight,
    Flown,
    Noise,
    Recorded,
    Reference,
)
from jaxatt.simulation.settling import Band, figures, follow, spend
from jaxatt.simulation.wheeled_body import WheeledBody, wheeled_body
from jaxatt.spacecraft.dynamics import AttitudeState
from jaxatt.spacecraft.vehicle import Spacecraft

__all__ = [
    "FLYING",
    "NOT_FINITE",
    "TUMBLING",
    "Flight",
    "Flown",
    "Noise",
    "Recorded",
    "Reference",
    "fly",
]


def fly(
    flight: Flight, craft: Spacecraft, start: AttitudeState, law: FeedbackLaw, key: Array
) -> Flown:
    """Fly one run of a flight.

    craft : the vehicle as it is, which may differ from the nominal one.
    start : q_ob, omega_ib, omega_bw at time zero.  law : its gains.  key : of the noise.
    """
    body, known = wheeled_body(craft), controller(flight, law)
    count = craft.wheels.count

    def record(
        state: RunState, inputs: tuple[tuple[Along, Nodes, Reference], tuple[Nodes, Reference]]
    ) -> tuple[RunState, Array]:
        within, end = inputs
        drawn = None
        if flight.noisy:
            samples = state.sample + jnp.arange(within[2].held.shape[0])
            drawn = deviates(key, samples, count)
        state, _ = lax.scan(
            lambda s, i: (_sample(flight, body, known, s, *i), None), state, (within, drawn)
        )
        return state, _row(flight, body, state, end)

    within = (flight.along, flight.nodes, flight.reference)
    end, rows = lax.scan(record, begin(flight, body, start, law), (within, flight.ends))
    edges = list(itertools.accumulate((4, 3, 3, 3, count, count, 3)))
    *recorded, errors = jnp.split(rows, edges, axis=1)
    total = end.sample * jnp.asarray(flight.period)
    found = figures(end.channels, end.effort, _band(flight), errors[-1], total)
    if flight.signal == "attitude":
        found = found._replace(rms=_angle(found.rms), final=_angle(found.final))
    found = found._replace(saturated=end.saturated / end.sample)
    return Flown(found, end.what, end.ended, Recorded(*recorded))


def _sample(
    flight: Flight,
    body: WheeledBody,
    known: Controller,
    state: RunState,
    inputs: tuple[Along, Nodes, Reference],
    drawn: Array | None,
) -> RunState:
    """Advance a run by one sampling period: measure, compute the torque, hold it."""
    along, nodes, reference = inputs
    motion, period, band = state.motion, jnp.asarray(flight.period), _band(flight)
    time = state.sample * period
    errors = measure(motion, nodes, reference)
    speeds = body.speeds(motion, state.spins)
    command, memory = known.decide(flight, state, speeds, errors, nodes, reference, drawn)
    nothing = combination((), (), motion.omega)
    driven = body.after_friction(command.wheels, speeds, period)
    torque = combination(body.axes, driven, motion.omega)
    after = RunState(
        motion=body.advance(
            motion, state.spins, torque, command.dipole, along, period, flight.torques
        ),
        spins=tuple(s + period * t for s, t in zip(state.spins, driven, strict=True)),
        memory=memory,
        channels=tuple(
            follow(c, e, time, period, band)
            for c, e in zip(state.channels, _signal(flight, errors), strict=True)
        ),
        effort=spend(state.effort, torque, period),
        driven=driven,
        dipole=nothing if command.dipole is None else command.dipole,
        saturated=state.saturated + _saturated(flight, command.dipole),
        what=state.what,
        ended=state.ended,
        sample=state.sample + 1,
    )
    return judged(state, after, time, flight.tumbling)


def _saturated(flight: Flight, dipole: Vector | None) -> Array | float:
    """1 where a dipole is at its limit, else 0."""
    if dipole is None:
        return 0.0
    assert flight.nominal.magnetorquers is not None
    limit = Vector.of(flight.nominal.magnetorquers.dipole_limit)
    full = [jnp.abs(m) >= most for m, most in zip(dipole.parts, limit.parts, strict=True)]
    return jnp.where(full[0] | full[1] | full[2], 1.0, 0.0)


def _row(flight: Flight, body: WheeledBody, state: RunState, end: tuple[Nodes, Reference]) -> Array:
    """One record of a run as a row: the fields of `Recorded` in order, then the watched errors
    (4,).
    """
    errors = measure(state.motion, *end)
    row = (
        *(errors.q_ob.eta, *errors.q_ob.eps.parts),
        *errors.attitude.eps.parts,
        *errors.rate.parts,
        *errors.omega_ob.parts,
        *body.speeds(state.motion, state.spins),
        *state.driven,
        *state.dipole.parts,
        *_signal(flight, errors),
    )
    return jnp.stack([jnp.asarray(value) for value in row])


def _signal(flight: Flight, errors: Errors) -> tuple[Scalar, ...]:
    """Errors on x, y, z and in total that `Flight.band` watches for settling.

    Of attitudes the sines of half the angles: the loop then needs no inverse functions.
    """
    watched = errors.attitude.eps if flight.signal == "attitude" else errors.rate
    return (*watched.parts, watched.norm())


def _band(flight: Flight) -> Band:
    """The settling band in the terms of `_signal`."""
    if flight.signal == "attitude":
        return Band(jnp.sin(0.5 * flight.band.width), flight.band.since)
    return flight.band


def _angle(sine: Array) -> Array:
    """Angle [rad] from the sine of half of it."""
    return 2.0 * jnp.arcsin(jnp.clip(sine, -1.0, 1.0))
