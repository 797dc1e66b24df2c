"""Flight of a body with wheels with an exact account of the energy that it gains and spends.

Powers are integrated by two Gauss points in each half of a Runge-Kutta step, at the motion in
between, so that the corners of positive parts and absolute values cost little; the light stands in
the weights, which resolve the edges of the shadow.  All lanes of a batch are scalars batched last.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from jaxatt.attitude.components import Vector, combination
from jaxatt.environment.external import Along, ExternalTorques
from jaxatt.runtime.arrays import Floats
from jaxatt.simulation.dense_step import Dipole, between, end, stages
from jaxatt.simulation.light_quadrature import SHARES, WEIGHTS
from jaxatt.simulation.powers import Powers
from jaxatt.simulation.rigid_step import Motion
from jaxatt.simulation.wheeled_body import WheeledBody


class Carried(NamedTuple):
    """State of a flight between two steps.

    motion : attitude and rate.  spins : axial momentum of each wheel, inertial [N m s].
    solar, wheels, magnetorquers : energy since the start of the interval [J].
    fastest : largest speed so far of each wheel [rad/s].  strongest : largest dipole [A m^2].
    """

    motion: Motion
    spins: tuple[Array, ...]
    solar: Array
    wheels: Array
    magnetorquers: Array
    fastest: tuple[Array, ...]
    strongest: Vector


class Step(NamedTuple):
    """Surroundings of one step; trailing axis of lanes, or 1 where all share them.

    along : (4, lanes).  sun : unit vector, inertial.  light : (4, lanes) [s], weights of the Gauss
    points with the visible fraction of the sun in them.
    """

    along: Along
    sun: Vector
    light: Array | Floats


class Interval(NamedTuple):
    """What an interval leaves: states and powers' integrals at its end, one row of a series."""

    motion: Motion
    speeds: tuple[Array, ...]
    solar: Array
    wheels: Array
    magnetorquers: Array


def begin(body: WheeledBody, motion: Motion, speeds: Array) -> Carried:
    """State before the first step; speeds : (n, lanes) [rad/s]."""
    nothing = jnp.zeros_like(motion.omega.x)
    return Carried(
        motion,
        body.spins(motion.omega, speeds),
        nothing,
        nothing,
        nothing,
        tuple(jnp.abs(speed) for speed in speeds),
        Vector(nothing, nothing, nothing),
    )


def fly_interval(
    body: WheeledBody,
    torques: ExternalTorques,
    powers: Powers,
    carried: Carried,
    wheel_torque: tuple[Array, ...],
    dipole: Dipole,
    steps: Step,
    step: Array,
) -> tuple[Carried, Interval]:
    """Fly one interval with held wheel torques [N m].

    steps : leading axis of the Runge-Kutta steps.  step : (lanes,) or (1,) [s], of one of them.
    """
    torque = combination(body.axes, wheel_torque, carried.motion.omega)

    def advance(at: Carried, surroundings: Step) -> tuple[Carried, None]:
        return _step(body, torques, powers, at, wheel_torque, torque, dipole, surroundings, step)

    nothing = jnp.zeros_like(carried.solar)
    carried = carried._replace(solar=nothing, wheels=nothing, magnetorquers=nothing)
    after, _ = lax.scan(advance, carried, steps)
    row = Interval(
        after.motion,
        body.speeds(after.motion, after.spins),
        after.solar,
        after.wheels,
        after.magnetorquers,
    )
    return after, row


def _step(
    body: WheeledBody,
    torques: ExternalTorques,
    powers: Powers,
    at: Carried,
    wheel_torque: tuple[Array, ...],
    torque: Vector,
    dipole: Dipole,
    surroundings: Step,
    step: Array,
) -> tuple[Carried, None]:
    """Advance by one Runge-Kutta step and add what it earns and spends."""
    spun = combination(body.axes, at.spins, at.motion.omega)
    begun = stages(at.motion, spun, torque, dipole, surroundings.along, step, body.body, torques)
    shares = jnp.asarray(SHARES)
    passed = shares[:, None] * step[None]
    motion = between(begun, step, shares)
    spins = tuple(s[None] + passed * t[None] for s, t in zip(at.spins, wheel_torque, strict=True))
    speeds = body.speeds(motion, spins)
    middle = jax.tree.map(lambda x: x[1][None], surroundings.along)
    moment = dipole(motion, _row(spun) + passed * _row(torque), middle)
    weights = jnp.asarray(WEIGHTS)[:, None] * step[None]
    sun_b = motion.q_ib.rotate_inverse(_row(surroundings.sun))
    held = tuple(t[None] for t in wheel_torque)
    earned = jnp.sum(surroundings.light * powers.solar(sun_b), axis=0)
    spent = jnp.sum(weights * powers.wheels(held, speeds), axis=0) if held else at.wheels * 0.0
    after = at._replace(
        motion=end(begun, step),
        spins=tuple(s + step * t for s, t in zip(at.spins, wheel_torque, strict=True)),
        solar=at.solar + earned,
        wheels=at.wheels + spent,
        fastest=tuple(
            jnp.maximum(most, jnp.max(jnp.abs(speed), axis=0))
            for most, speed in zip(at.fastest, speeds, strict=True)
        ),
    )
    if moment is not None:
        drawn = jnp.sum(weights * powers.magnetorquers(moment), axis=0)
        after = after._replace(
            magnetorquers=at.magnetorquers + drawn,
            strongest=at.strongest.map(
                lambda most, m: jnp.maximum(most, jnp.max(jnp.abs(m), axis=0)), moment
            ),
        )
    return after, None


def _row(v: Any) -> Any:
    """The same with a leading axis of one, for the points within a step."""
    return jax.tree.map(lambda x: x[None], v)
